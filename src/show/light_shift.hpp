#pragma once
/// How far the light on a plane is from its place, by the covariance of the pose that it was drawn for.
#include <optional>

#include "procam/core/geometry/se3.hpp"
#include "procam/core/surface/planar.hpp"

namespace procam::show {

/// The middle of a plane's content, metres on the plane; nullopt where the plane's area has none.
std::optional<Vec2> content_centre(const PlacedPlane& plane);

/// Covariance in the world, metres^2, of the shift of the light at the middle of the content. To first order, for a point p
/// lit along d, a normal n, all in the world, and the pose's left increment [w, v]:
///   shift = (I - d n^T / (n . d)) (w x p + v).
/// nullopt where no light can be: the plane is edge-on.
std::optional<Mat3> light_shift(const PlacedPlane& plane, const Pose& world_from_projector,
                                const Mat6& covariance);
/// The same at a point of the plane, metres.
std::optional<Mat3> light_shift(const PlacedPlane& plane, const Vec2& point, const Pose& world_from_projector,
                                const Mat6& covariance);

/// Mean square shift over the corners of the content, metres^2; of an increment xi with the covariance xi xi^T. 0 where no light
/// can be.
double mean_square_shift(const PlacedPlane& plane, const Pose& world_from_projector, const Mat6& covariance);

}  // namespace procam::show
