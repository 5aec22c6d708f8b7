#pragma once
/// What is known of the wall behind clicked corners, other than by patterns of light (wall.hpp).
///
///   depth    an image of the rig's depth camera: each reading z of a pixel with ray (x, y, 1) is the point z (x, y, 1)
///   marker   a marker that hangs flat on the wall, its size known: the wall is its plane (track/locate.hpp)
///   size     the tape's width and height between the clicked corners: the plane from which the camera sees this rectangle
///            there (core/geometry/planar_pose.hpp)
#include "procam/core/base/image.hpp"
#include "procam/core/board/marker.hpp"
#include "procam/core/geometry/plane.hpp"
#include "procam/depth/depth_image.hpp"
#include "procam/device/depth_source.hpp"
#include "procam/session/capture.hpp"
#include "wall.hpp"

namespace procam::studio {

/// The mean of the next `count` images, of each pixel's readings; 0 where fewer than half of them have one. `pump` is called
/// in between. Throws as the source does, Error(kDevice) if no image comes for 5 s, Error(kInput) if their size is not that
/// of the rig's camera: the depth images' pixels must be its pixels.
ImageF mean_depth(device::DepthSource& source, const Camera& camera, int count,
                  const std::function<void()>& pump);

/// Every second pixel in each direction that has a depth. Throws Error(kNotEnoughData) where
/// none has one.
std::vector<ScanPoint> points_of_depth(const depth::DepthImage& image, const Rig& rig);

/// The mean of `count` images of the scene in the light of `picture`, rounded: the tilt of a small marker's plane is limited
/// by the noise of its edges. Throws as the shutter does.
ImageU8 mean_image(session::Shutter& shutter, ViewU8 picture, int count);

/// The plane of the one marker of `map` in the camera's image, in the rig's frame. Throws as track::locate() does.
Plane plane_of_marker(ViewU8 image, const Rig& rig, const MarkerMap& map);

/// The plane on which the corners are width x height (metres) apart. Throws Error(kInput) for lengths that are not
/// 1 cm to 100 m, or corners of which no rectangle can be seen.
Plane plane_of_size(const Rig& rig, const CameraCorners& corners, double width, double height);

}  // namespace procam::studio
