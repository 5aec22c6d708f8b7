#pragma once
/// The body of triangulate.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <string>

#include "procam/core/base/cholesky.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/geometry/triangulate.hpp"

namespace procam {

PROCAM_CORE_INLINE std::optional<Triangulation> triangulate(const std::vector<Ray>& rays,
                                                            const TriangulationOptions& options) {
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
// NOLINTEND(misc-definitions-in-headers)
