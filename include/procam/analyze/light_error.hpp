#pragma once
/// How far from its place the light lands, on a wall across the projector's axis.
///
/// The wall stands in the rig's frame, perpendicular to the optical axis at a given distance from the lens. A
/// pixel's light lands at the point X of the wall with project(lens, projector_from_rig X) = pixel. With X =
/// X0 + E a (E two unit vectors in the wall) the implicit function theorem gives, for parameters p (lens and
/// pose),
///   da/dp = -(d pixel / d a)^-1 (d pixel / d p),     cov(a) = (da/dp) cov(p) (da/dp)^T.
/// First order; exact derivatives through core's dual numbers.
#include <optional>
#include <string>

#include "procam/core/plane.hpp"
#include "procam/core/rig.hpp"

namespace procam::analyze {

/// Where one pixel's light lands, and how well that is known.
struct LandedLight {
  Vec3 in_rig;                       ///< metres
  Eigen::Matrix<double, 3, 2> axes;  ///< two unit vectors along the wall, rig frame
  Mat2 covariance;                   ///< of the place along the axes, metres^2
};

/// nullopt where the light misses the wall. Throws Error(kInput) when the rig carries no covariance of that
/// projector.
std::optional<LandedLight> landed_light(const Rig& rig, const Plane& wall_in_rig, const Vec2& pixel,
                                        const std::string& projector = "");

/// Over a grid of 17 x 13 pixels that spans the projector's picture.
struct LightError {
  double distance = 0;         ///< metres from the lens to the wall
  double mean_mm = 0;          ///< mean distance between true and estimated light; not set for a prediction
  double rms_mm = 0;           ///< root of the mean squared distance (predicted: of the mean trace of cov(a))
  double worst_mm = 0;         ///< largest on the grid (predicted: root of the largest trace)
  std::string projector = "";  ///< whose light
};

/// What the rig's covariance means on the wall. Throws Error(kInput) when the rig carries no covariance of
/// that projector, std::invalid_argument unless distance > 0.
LightError predicted_light_error(const Rig& rig, double distance, const std::string& projector = "");

/// Where an estimated rig's light lands against where it truly lands; both rigs share the rig frame.
LightError true_light_error(const Rig& estimated, const Rig& truth, double distance,
                            const std::string& projector = "");

}  // namespace procam::analyze
