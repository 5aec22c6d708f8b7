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
};

/// The pose of one view: distances from near to far, tilts about all axes in turn, in the light.
GuidedPose guided_pose(int view, const Board& board, ImageSize camera_size, const LitBox& lit);

/// The corners of the board's print in a camera's image; empty where one is not in front of it.
std::vector<Vec2> outline(const Board& board, const Pose& camera_from_board, const Camera& camera);

}  // namespace procam::studio
