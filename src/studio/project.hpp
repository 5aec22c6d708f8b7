#pragma once
/// The folder of a project: where its files are, and studio.json, the step and what was chosen.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/types.hpp"

namespace procam::studio {

/// In the order in which they are taken.
enum class Step { kDisplay, kCamera, kBoard, kCapture, kCalibrate, kSurfaces, kContent, kShow };
inline constexpr int kSteps = 8;

/// "display", "camera", ...
const char* to_string(Step step);
std::optional<Step> step_named(const std::string& name);

struct ChosenProjector {
  std::string name;     ///< in the session and the rig; empty: the only one
  std::string display;  ///< as device::find_display() takes it; "simulated"
};

/// What a person has chosen: studio.json.
struct Choices {
  Step step = Step::kDisplay;
  std::string display;                        ///< of the first projector; empty: none yet
  std::vector<std::string> further_displays;  ///< one a further projector
  std::string camera;                         ///< as device::open_camera() takes it; "simulated"
  std::string camera_size;                    ///< "1280x720"; empty: the driver's
  std::string exposure;                       ///< in the camera driver's unit; empty: as it is
  std::string paper = "a4";
  std::string board;     ///< as it was drawn; board.json has its measured size
  std::string measured;  ///< length of its printed ruler, "99.6mm"; empty: 100 mm
  std::string pattern = "gray";
  int views = 8;
  double accept_mm = 5;
  std::string measure_by = "light";  ///< what measures the wall: "light", "depth", "marker" or "size"
  std::string depth;  ///< the depth camera, as device::open_depth() takes it; simulated: not used
  std::string marker = "4x4_50:0:190mm";  ///< on the wall, as io::parse_marker() takes it
  int camera_checked = 0;                 ///< 1: the camera has seen black and white

  /// Several are named projector_1, projector_2, ...
  std::vector<ChosenProjector> projectors() const;
};

class Project {
 public:
  /// Makes the folder unless it exists, and reads studio.json where there is one. Throws Error(kIo), Error(kInput) with the
  /// file and the field.
  explicit Project(const std::filesystem::path& folder);

  Choices choices;
  /// Writes studio.json.
  void save() const;

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path board() const { return folder_ / "board.json"; }
  std::filesystem::path board_sheet() const { return folder_ / "board.pdf"; }
  std::filesystem::path session() const { return folder_ / "session"; }
  std::filesystem::path rig() const { return folder_ / "rig.json"; }
  std::filesystem::path report() const { return folder_ / "report.html"; }
  std::filesystem::path scan() const { return folder_ / "scan"; }
  /// Of the rig's depth camera, metres; and the camera's image of a marker on the wall.
  std::filesystem::path wall_depth() const { return folder_ / "wall_depth.pfm"; }
  std::filesystem::path wall_marker() const { return folder_ / "wall_marker.png"; }
  std::filesystem::path check() const { return folder_ / "check"; }
  /// What a correction of the rig replaces is moved here.
  std::filesystem::path before_correction() const { return folder_ / "before_correction"; }
  std::filesystem::path surfaces() const { return folder_ / "surfaces.json"; }
  /// Surfaces in projector pixels, mapped by hand.
  std::filesystem::path mapping() const { return folder_ / "mapping.json"; }
  std::filesystem::path show() const { return folder_ / "show.json"; }
  std::filesystem::path service() const { return folder_ / "procam-show.service"; }

  /// Other JSON files of the folder, by name: they may hold surfaces.
  std::vector<std::string> surface_files() const;

  /// Complete views in session/.
  int views_captured() const;
  /// Is the wall measured in the chosen way?
  bool is_wall_measured() const;
  /// Is the step's result in the folder?
  bool is_done(Step step) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace procam::studio
