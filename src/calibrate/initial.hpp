#pragma once
/// Starting values, without a guess at the principal point of a projector.
#include <optional>
#include <string>
#include <vector>

#include "procam/core/geometry/pose.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam::calibrate {

/// fx and fy of a camera from homographies pixel_from_board (3x3, board in metres on z = 0), principal point
/// at the image's centre, no skew: two linear equations a view in 1/fx^2 and 1/fy^2 (Zhang, "A flexible new
/// technique for camera calibration", PAMI 22(11), 2000, section 3.1). nullopt when the views do not
/// determine a positive answer (all boards parallel to the image).
std::optional<Intrinsics> initial_camera_intrinsics(const std::vector<Mat3>& pixel_from_board,
                                                    ImageSize size);

/// A device resected from points known in three dimensions.
struct Resection {
  Intrinsics intrinsics;
  Pose device_from_points;
  double rms_px = 0;
};

/// Pinhole with any principal point and skew from N >= 6 points that do not lie in one plane, by one
/// normalised DLT (Abdel-Aziz and Karara, 1971; Hartley and Zisserman, "Multiple View Geometry", 2004,
/// algorithm 7.1) and RQ.
///
/// This is how a projector starts: all board points put into the camera's frame by their poses. It needs no
/// guess, where starting at the image's centre fails on real projectors, whose principal point lies near or
/// below the bottom edge. Throws Error(kNotEnoughData) for fewer than six, Error(kDegenerate) for points of
/// one plane.
Resection resect(const Points3& points, const Points2& pixels, const std::string& device);

}  // namespace procam::calibrate
