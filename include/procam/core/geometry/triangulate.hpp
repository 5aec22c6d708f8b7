#pragma once
/// The point where two or more rays meet, with its uncertainty.
///
/// The point minimises the weighted squared distance to the rays' lines,
///
///   sum_i |(I - d_i d_i^T) (p - o_i)|^2 / (s_i sigma_i)^2,
///
/// d_i unit direction, o_i origin, sigma_i the ray's angular standard deviation in radians about each axis
/// across it, s_i the distance from o_i to p: near rays count more, as their error is smaller there. The
/// first pass takes all s_i equal, the following ones the distances of the last. (Midpoint method for two
/// rays of equal range; Hartley & Sturm 1997 discuss why it suffices for well-calibrated rays of comparable
/// range.)
///
/// No answer: rays that are parallel (or one), and a meeting point behind an origin.
#include <optional>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/geometry/ray.hpp"

namespace procam {

struct TriangulationOptions {
  /// Angular standard deviation of every ray, radians; a pixel of 1/1500 of the focal length, halved.
  double sigma = 3e-4;
  /// Rays count as parallel when the largest angle among them is below this, radians. 0.05 degrees: a 0.5 m
  /// baseline seen from 600 m.
  double parallel_tolerance = 1e-3;
};

struct Triangulation {
  Vec3 point = Vec3::Zero();
  Mat3 covariance = Mat3::Zero();  ///< m^2, for rays of angular noise options.sigma and exact origins
  double rms_distance = 0.0;       ///< of the point from the rays, metres
  std::vector<double> distances;   ///< per ray, metres
};

/// All rays in one frame; the point is in it as well. Fewer than two rays: std::invalid_argument.
PROCAM_EXPORT std::optional<Triangulation> triangulate(const std::vector<Ray>& rays,
                                                       const TriangulationOptions& options = {});

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/geometry/detail/triangulate_body.hpp"
#endif
