#pragma once
/// Where to hold the board next, before anything is calibrated.
///
/// The poses are stated for a camera with square pixels, 0.85 image widths of focal length and its axis in the middle: wrong
/// by some 20 % for most cameras, which changes how large the outline is drawn and nothing that is measured.
#include <string>
#include <vector>

#include "procam/core/board/board.hpp"
#include "procam/core/geometry/pose.hpp"
#include "procam/core/lens/camera.hpp"
#include "procam/core/lens/projector.hpp"

namespace procam::studio {

/// The camera that the poses are stated for.
Camera assumed_camera(ImageSize size);

/// The part of a camera image that the projector lights, pixels.
struct LitBox {
  Vec2 low = Vec2::Zero(), high = Vec2::Zero();
};

struct GuidedPose {
  Pose camera_from_board;
  Camera camera;              ///< that it is drawn for
  std::string words;          ///< "0.9 m away, upper edge tilted towards you"
  std::size_t projector = 0;  ///< in whose light it is
  /// The board's rectangle in the frame of this projector, pixels, with a margin round the print; empty: not known.
  std::vector<Vec2> in_frame = {};
};

/// The pose of one view: distances from near to far, tilts about all axes in turn, in the light.
GuidedPose guided_pose(int view, const Board& board, ImageSize camera_size, const LitBox& lit);

/// The corners of the board's print in a camera's image, with a margin round it in metres; empty where one is not in front of
/// it.
std::vector<Vec2> outline(const Board& board, const Pose& camera_from_board, const Camera& camera,
                          double margin = 0);

/// Round the points of a board, metres: light at this distance does not touch their corners.
double light_margin(const Board& board);

/// The outline in a frame of this size by a rig estimate, pixels; empty where no corner is in the frame.
std::vector<Vec2> outline_in_frame(const Board& board, const Pose& projector_from_board,
                                   const Projector& projector);

/// The same without a rig: by the part of the camera image that the frame lights. On a wall it is exact to the lit box. For a
/// board in front of the wall it is displaced by the parallax.
std::vector<Vec2> outline_in_frame(const Board& board, const GuidedPose& pose, const LitBox& lit,
                                   ImageSize frame);

}  // namespace procam::studio
