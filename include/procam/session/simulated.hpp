#pragma once
/// A simulated calibration session as a folder: what capture-session records, with the truth beside it.
///
///   session/session.json, view_00/frame_00.png ...   as captured
///   session/truth.json, view_00/truth_pose.json ...  the true rig and board poses
///   session/marker_view.png, markers.json, truth_projector_from_world.json   with `markers`
///   session/check/frame_00.png ..., session.json, surfaces.json, truth.json  with `check`
///
///   session/view_00/truth_depth.pfm, truth_camera.json   with `room`: the camera's depths in metres, and its pose
///   in the rig;
///                                                        of several cameras truth_depth_NAME.pfm, truth_NAME.json
///   session/truth_station.json                       with `room`: the pose of the rig, world_from_rig
///
/// Equal options give equal folders. Several cameras or projectors have a folder each in a view
/// (simulate/fleet.hpp).
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/board/board.hpp"
#include "procam/session/reader.hpp"
#include "procam/simulate/session.hpp"

namespace procam::session {

struct SimulationOptions {
  std::uint64_t seed = 1;
  simulate::Level level = simulate::Level::kEasy;
  std::string pattern = "gray";  ///< pattern_help()
  std::optional<Board> board;    ///< the printed board instead of the level's
  int views = 0;                 ///< only the first ones; 0: all of the level
  int cameras = 1, projectors = 1;
  std::vector<std::string> settings;  ///< KEY=VALUE changes to the level's conditions: settings_help()
  bool markers = false;               ///< also a view of markers on the wall (simulate/marker_view.hpp)
  std::string check;                  ///< also captures of this projected board on the bare wall
  /// A change of the (first) projector after the calibration with the same seed: rotation in radians, and a factor of
  /// its focal lengths. With `check` it comes before `check`, else before the views, which are then the level's last.
  double bump = 0, zoom = 1;
  /// A room of simulate/scan_view.hpp instead of boards. One view to scan, or `views` between which the cameras are
  /// moved and the projectors stand still (simulate::moved_camera).
  std::string room;
  /// In a room: the whole rig stands at this station (simulate::room_from_rig), with noise of its own.
  int station = 0;
  bool replace = false;  ///< remove an earlier simulated session
};

/// The folder as it was written.
struct SimulatedFolder {
  int views = 0;
  int frames_per_view = 0;
  std::string pattern;
  Board board;  ///< none in a room
  ImageSize projector_size;
};

/// The keys of `settings` with an example and their meaning, for --help.
PROCAM_EXPORT std::string settings_help();

/// The folder appears whole or not at all. Throws Error(kIo) for a folder that is not empty (unless `replace`,
/// and then for one that is no simulated session), Error(kInput) for settings that cannot be read,
/// Error(kUnsupported) for `markers`, `check` and `board` with several devices or in a `room`, and as make_session()
/// does.
PROCAM_EXPORT SimulatedFolder write_simulated_session(const std::filesystem::path& folder,
                                                      const SimulationOptions& options,
                                                      const ReadingProgress& progress = {});

}  // namespace procam::session
