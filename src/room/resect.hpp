#pragma once
/// A device from points in space and where it sees them: pose, and for a lens that is not known the focal length and
/// the principal point as well, wherever it is.
///
/// Starts: the direct linear transform (Hartley & Zisserman, 7.1), whole for an unknown lens and normalised by each
/// lens of a grid of focal lengths and lens shifts; for points near a plane the poses of its homography
/// (core/geometry/planar_pose.hpp). Each is refined by Gauss-Newton with the loss of Huber; what is known of the
/// lens is part of the cost.
#include <vector>

#include "procam/core/geometry/pose.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam::room {

/// What is known of a lens before: mean and standard deviation, pixels.
struct LensGuess {
  ImageSize size;
  double focal = 0, focal_sigma = 0;  ///< relative sigma, of its logarithm
  Vec2 centre = Vec2::Zero(), centre_sigma = Vec2::Zero();
};

struct Resection {
  Pose device_from_rig;
  Intrinsics lens;
  double cost = 0;  ///< mean over the points of the robust squares, with the guess; pixels^2
  double rms = 0;   ///< of all points below three times the median, pixels
};

/// The best few, best first. `points` in the rig's frame, `pixels` of the device. Fewer than six points give none.
std::vector<Resection> resect_with_lens(const Points3& points, const Points2& pixels, const LensGuess& guess);

/// Of a device whose lens is known: `rays` are the points' (a, b, 1), `focal` turns them into pixels.
std::vector<Resection> resect_known(const Points3& points, const Points2& rays, double focal);

/// The lenses that a search begins with: focal lengths by lens shifts.
std::vector<Intrinsics> lens_grid(const LensGuess& guess);

}  // namespace procam::room
