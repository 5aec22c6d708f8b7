#pragma once
/// Whole calibration sessions from a seed: a rig, a board in several poses, and how it was photographed.
///
///   easy   in focus, little noise and distortion; camera 1280x1024, board 10x7
///   paper  the rig of an office projector on a table: frame above the axis (principal point near the bottom
///          edge), camera 1280x960 with moderate distortion; board 9x6
///   hard   strong barrel distortion, projector lens distorted too and its axis below the frame, blurred,
///          grey print, room light; every third board partly outside the projected frame, so that its border
///          crosses the print; board 7x9 (odd x odd: a detector may turn it by 180 degrees)
///
/// Levels paper and hard violate what calibration assumes (level_conditions(), conditions.hpp): skew, k3, the
/// camera's gamma with noise before it, vignetting, indirect light, glare and defocus; hard also has views
/// that are dark, overexposed, with a board that moved and with a stale frame.
///
/// A pattern that needs blank paper beside the print (a projected chessboard) gets sheets with it, in 18
/// poses and in a lit room: the print need not lie in the projector's picture then.
///
/// A board of one's own takes the place of the level's, on the level's paper. When its markers say which
/// point is which (ChArUco, marker grids), every third view shows the camera only a part of it.
///
/// The seed moves every parameter of the rig and every pose; equal seeds give equal sessions. The camera's
/// frame is the rig's frame. Unless said above, the whole sheet is on the camera's image, and every board
/// point is lit.
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/simulate/capture.hpp"
#include "procam/simulate/conditions.hpp"

namespace procam::simulate {

enum class Level { kEasy, kPaper, kHard };

PROCAM_EXPORT const char* to_string(Level level);
/// Throws Error(kUnsupported) for an unknown name.
PROCAM_EXPORT Level level_named(const std::string& name);
/// The size of the level's projector picture.
PROCAM_EXPORT ImageSize projector_size(Level level);

/// The level's departures from what calibration assumes: none for easy.
PROCAM_EXPORT Conditions level_conditions(Level level);

struct SimulatedSession {
  Level level = Level::kEasy;
  std::vector<World> views;  ///< one a board pose; the same rig, board and wall in each
  CaptureOptions capture;
  std::vector<ViewDefects> defects;  ///< of each view; empty: none has any
  Conditions conditions;             ///< that it was made with
  /// By view: the camera's lens as it was focused and stabilised there; empty: in all as the rig has it.
  std::vector<Camera> lenses;
  Board stated_board;  ///< as its user believes it to be: print_scale is not in it

  const Rig& rig() const { return views.front().rig; }
  const PrintedBoard& board() const { return views.front().board; }
};

/// A board and its drawing (detect::board_artwork; a chessboard needs none).
struct BoardPrint {
  Board layout;
  BoardArtwork artwork = {};
};

/// `on_blank_paper` is the part of the projector's picture that lands on blank paper in every view. Throws
/// Error(kNotConverged) when no poses are found that camera and projector both cover, std::invalid_argument
/// for conditions out of range. Without conditions: those of the level.
PROCAM_EXPORT SimulatedSession make_session(
    Level level, std::uint64_t seed, const std::optional<Eigen::AlignedBox2d>& on_blank_paper = std::nullopt,
    const std::optional<BoardPrint>& print = std::nullopt);
PROCAM_EXPORT SimulatedSession make_session(Level level, std::uint64_t seed,
                                            const std::optional<Eigen::AlignedBox2d>& on_blank_paper,
                                            const std::optional<BoardPrint>& print,
                                            const Conditions& conditions);

/// The captures of one view while the projector shows `frames`. Noise differs from view to view.
PROCAM_EXPORT std::vector<ImageU8> capture_view(const SimulatedSession& session, std::size_t view,
                                                const std::vector<ImageU8>& frames);

}  // namespace procam::simulate
