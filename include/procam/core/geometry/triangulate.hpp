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
#include <Eigen/Eigenvalues>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/cholesky.hpp"
#include "procam/core/base/error.hpp"
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
inline std::optional<Triangulation> triangulate(const std::vector<Ray>& rays,
                                                const TriangulationOptions& options = {}) {
  require(rays.size() >= 2, "triangulate: " + std::to_string(rays.size()) + " ray(s), two are needed");
  require(options.sigma > 0.0, "triangulate: sigma must be positive");
  std::vector<Mat3> across;  // projects off the ray
  Mat3 sum = Mat3::Zero();
  for (const Ray& ray : rays) {
    const double length = ray.direction.norm();
    require(length > 0.0 && std::isfinite(length) && ray.origin.allFinite(),
            "triangulate: a ray without direction or not finite");
    const Vec3 d = ray.direction / length;
    across.push_back(Mat3::Identity() - d * d.transpose());
    sum += across.back();
  }
  // For two rays at angle a the smallest eigenvalue of the sum is 1 - cos a, about a^2 / 2; more rays only
  // add.
  const double smallest = Eigen::SelfAdjointEigenSolver<Mat3>(sum, Eigen::EigenvaluesOnly).eigenvalues()[0];
  if (!(smallest > 0.5 * options.parallel_tolerance * options.parallel_tolerance)) return std::nullopt;

  Triangulation result;
  std::vector<double> range(rays.size(), 1.0);
  Mat3 information;
  constexpr int kPasses = 4;  // the weights change by the relative change of range: three digits a pass
  for (int pass = 0; pass < kPasses; ++pass) {
    information.setZero();
    Vec3 right = Vec3::Zero();
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const double sigma = options.sigma * range[i];
      information += across[i] / (sigma * sigma);
      right += across[i] * rays[i].origin / (sigma * sigma);
    }
    result.point = Cholesky(information).solve(right);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (!(rays[i].direction.dot(result.point - rays[i].origin) > 0.0)) return std::nullopt;
      range[i] = (result.point - rays[i].origin).norm();
    }
  }
  result.covariance = information.inverse();
  double squared = 0.0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    result.distances.push_back((across[i] * (result.point - rays[i].origin)).norm());
    squared += result.distances.back() * result.distances.back();
  }
  result.rms_distance = std::sqrt(squared / double(rays.size()));
  return result;
}

}  // namespace procam
