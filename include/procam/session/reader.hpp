#pragma once
/// A session folder -> correspondences, whatever pattern it was captured with. The one home of this reading:
/// tools and end-to-end tests share it.
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/core/rig/view_image.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/session/patterns.hpp"
#include "procam/session/shown_views.hpp"

namespace procam::session {

struct PlannedProjector {
  std::string name;
  ImageSize size;
  std::unique_ptr<SessionPattern> pattern;  ///< none in sessions of photographs and of decoded maps
};

struct PlannedView {
  std::string name;
  std::vector<io::Stack> stacks;
};

/// A session with everything known that its reading needs.
struct SessionPlan {
  std::filesystem::path folder;
  std::vector<std::string> cameras;  ///< natural order; the first one's frame will be the rig's
  std::vector<PlannedProjector> projectors;
  int step = 1;
  std::filesystem::path
      pattern_file;  ///< of another program's frames (io/session/pattern_file.hpp); empty: none
  Board board;
  std::vector<PlannedView> views;
  std::optional<ShownViews> shown;  ///< a session of one photograph a view; then `views` have no stacks
  bool decoded = false;  ///< views hold decoded maps (io/session/decoded_view.hpp) instead of frames
  bool through_mirror =
      false;  ///< turn every frame left to right before it is read (core/geometry/mirror.hpp)
};

constexpr const char* kDecodedMaps = "decoded";

/// u -> width - 1 - u.
PROCAM_EXPORT void turn_left_to_right(ImageU8& image);
PROCAM_EXPORT void turn_left_to_right(ImageF& image);

/// What a caller knows of a session; it goes before what session.json states.
struct OpenOptions {
  io::SessionInfo stated;   ///< pattern, sizes, board, step
  ShownFlags shown;         ///< of a session of one photograph a view
  bool needs_board = true;  ///< false: the light on whatever it falls on is read (session/light.hpp)
};

/// What is to be read, without reading an image: `options` first, then session.json; without either the
/// pattern is "gray". Throws Error(kInput) naming the flag that would answer what neither says, and for folders
/// that do not tell which device they belong to. The pattern kDecodedMaps stands for views that another program
/// has decoded.
///
///   const auto session = session::read(session::open("captures"));
///   const auto result = calibrate::calibrate_rig(session.correspondences);
///   io::save_rig("rig.json", result.rig);
PROCAM_EXPORT SessionPlan open(const std::filesystem::path& folder, const OpenOptions& options = {});

/// As --pattern states it; of photographs "shown", of decoded maps "decoded".
PROCAM_EXPORT std::string pattern_text(const SessionPlan& plan);

/// Called before each view is read: name, number done, number of all.
using ReadingProgress = std::function<void(const std::string& view, int done, int total)>;

/// What a calibration works on, whether it comes from images or from a table of observations.
struct SessionContents {
  Correspondences correspondences;
  std::vector<InputFile> inputs;               ///< every file that was read
  std::map<std::string, std::string> options;  ///< pattern, sizes, board: for the rig's provenance
  int views = 0;                               ///< given, also those without enough points
  std::string title;                           ///< of the report: the folder's or the file's name
  /// The brightest frame of each view and camera, at most 480 pixels wide and high; none from tables.
  std::vector<ViewImage> view_images;
};

/// Reads and joins all views: cameras first among the devices, then projectors. A board missed in one view is
/// a remark; one found in none of the first three views is an Error(kInput), as is whatever is wrong with a
/// view's files. An image whose size is not that of most of its camera's images is rejected by name; a view
/// that then has too few frames is rejected with it.
/// Files that repeat another view's are warned of ("identical_files").
PROCAM_EXPORT SessionContents read(const SessionPlan& plan, const ReadingProgress& progress = {});

/// A table of observations (io/session/observations_file.hpp); `devices` and `board` as far as the caller knows
/// them. Views without four points in any camera are rejected with a warning, as in a session of images. Throws
/// as io::load_observations().
PROCAM_EXPORT SessionContents read_observations(const std::filesystem::path& file,
                                                const std::vector<Device>& devices = {},
                                                const std::optional<Board>& board = {});

/// The images of a folder (png, jpg, bmp, tif), each one view of the board by one camera called "camera". Images
/// whose size is not that of most are rejected by name. Throws Error(kInput) for a folder without images and for
/// images without the board, Error(kIo) for what cannot be read.
PROCAM_EXPORT SessionContents read_board_images(const std::filesystem::path& folder, const Board& board,
                                                const ReadingProgress& progress = {});

/// The board's points in one image file. Throws Error(kIo), Error(kInput) for what cannot be read.
PROCAM_EXPORT Detections read_board_image(const std::filesystem::path& file, const Board& board);

/// For the rig that was solved from the contents: `program`, procam's version, the time (SOURCE_DATE_EPOCH
/// where it is set: https://reproducible-builds.org/specs/source-date-epoch), what was read.
PROCAM_EXPORT Provenance provenance(const SessionContents& contents, const std::string& program);

/// The devices of a session with one of each, in the order of kCameraDevice, kProjectorDevice.
PROCAM_EXPORT std::vector<Device> session_devices(ImageSize camera_size, ImageSize projector_size);

}  // namespace procam::session
