#pragma once
/// The frame of a plane, upright as it is read.
#include "procam/depth/areas.hpp"

namespace procam::depth {

/// Upright as read, at `origin` (brought onto the plane). `up` and `forward` are directions in the plane's
/// frame, e.g. (0, -1, 0) and (0, 0, 1) for a level camera; what is read is the side of the normal.
Pose upright_frame(const Plane& plane, const Vec3& origin, const Vec3& up,
                   const Vec3& forward = Vec3::UnitZ());

}  // namespace procam::depth
