#include "procam/scan/scan_error.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "procam/core/base/stats.hpp"

namespace procam::scan {
namespace {

constexpr int kReach = 2;       // pixels
constexpr double kStep = 0.02;  // of the depth: a step

/// Measured minus true depth, of the side of a step that is nearer to the measurement.
double depth_error(double measured, ViewF truth, int x, int y) {
  const double here = truth.at(x, y);
  double error = measured - here;
  for (int j = std::max(0, y - kReach); j <= std::min(truth.height - 1, y + kReach); ++j)
    for (int i = std::max(0, x - kReach); i <= std::min(truth.width - 1, x + kReach); ++i) {
      const double other = truth.at(i, j);
      if (other > 0 && std::abs(other - here) > kStep * here && std::abs(measured - other) < std::abs(error))
        error = measured - other;
    }
  return error;
}

/// |ray . normal| of the true surface: what a change of depth moves along the normal. The ray has z 1.
double along_normal(ViewF truth, const ImageF& rays, int x, int y) {
  const auto point = [&](int i, int j) {
    const double z = truth.at(i, j);
    return Vec3(z * rays.at(i, j, 0), z * rays.at(i, j, 1), z);
  };
  const auto slope = [&](int dx, int dy) -> std::optional<Vec3> {
    const int x0 = x - dx, x1 = x + dx, y0 = y - dy, y1 = y + dy;
    if (x0 < 0 || y0 < 0 || x1 >= truth.width || y1 >= truth.height) return std::nullopt;
    const double a = truth.at(x0, y0), b = truth.at(x1, y1), z = truth.at(x, y);
    if (!(a > 0 && b > 0) || std::abs(a - z) > kStep * z || std::abs(b - z) > kStep * z) return std::nullopt;
    return Vec3(point(x1, y1) - point(x0, y0));
  };
  const std::optional<Vec3> along_x = slope(1, 0), along_y = slope(0, 1);
  const Vec3 ray(rays.at(x, y, 0), rays.at(x, y, 1), 1);
  if (!along_x || !along_y) return ray.norm();
  return std::abs(along_x->cross(*along_y).normalized().dot(ray));
}

}  // namespace

ScanError compare(const Scan& scan, ViewF true_depth) {
  require(true_depth.size() == scan.depth.size() && true_depth.channels == 1,
          "compare: the true depths have another size than the scan");
  const ImageF rays = pixel_rays(scan.camera.camera);
  ScanError error;
  std::vector<double> distances;
  double squares = 0, expected = 0, noise = 0;
  int inside = 0, outliers = 0;
  for (int y = 0; y < scan.depth.height(); ++y)
    for (int x = 0; x < scan.depth.width(); ++x) {
      if (!scan.measured(x, y) || !(true_depth.at(x, y) > 0)) continue;
      const double off = std::abs(depth_error(scan.depth.at(x, y), true_depth, x, y));
      const double sigma = scan.total_sigma(x, y), cosine = along_normal(true_depth, rays, x, y);
      const double distance = off * cosine;
      if (off > 0.01 && off > 10 * sigma) {
        ++outliers;
      } else {
        squares += distance * distance;
        expected += sigma * sigma * cosine * cosine;
        noise += double(scan.sigma.at(x, y)) * double(scan.sigma.at(x, y)) * cosine * cosine;
      }
      distances.push_back(distance);
      inside += off <= 3 * sigma;
    }
  error.compared = int(distances.size());
  if (distances.empty())
    throw Error(ErrorKind::kNotEnoughData, "scan", "no measured pixel has a true depth",
                "give the true depths of this view");
  const double count = double(distances.size()), kept = std::max(1.0, count - outliers);
  error.rms = std::sqrt(squares / kept);
  error.expected_rms = std::sqrt(expected / kept);
  error.noise_rms = std::sqrt(noise / kept);
  error.median = median(distances);
  error.inside_3_sigma = inside / count;
  error.outliers = outliers / count;
  return error;
}

}  // namespace procam::scan
