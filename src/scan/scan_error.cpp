#include "procam/scan/scan_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
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

/// Distances of points from the true surfaces.
struct ErrorSums {
  std::vector<double> distances;
  struct Squares {
    double off = 0, expected = 0, noise = 0;
    int count = 0;
  };
  Squares kept, all;  ///< without outliers, and with them
  int inside = 0, outliers = 0;

  void add(double distance, double expected, double noise, bool is_outlier) {
    distances.push_back(distance);
    outliers += is_outlier;
    const auto add_to = [&](Squares& sums) {
      sums.off += distance * distance;
      sums.expected += expected * expected;
      sums.noise += noise * noise;
      ++sums.count;
    };
    add_to(all);
    if (!is_outlier) add_to(kept);
  }

  ScanError error() const {
    if (distances.empty())
      throw Error(ErrorKind::kNotEnoughData, "scan", "no measured pixel has a true depth",
                  "give the true depths of this view");
    ScanError out;
    out.compared = int(distances.size());
    const double count = double(distances.size());
    // Where most are outliers, the few others tell nothing of the scan.
    const Squares& sums = outliers > 0.5 * count ? all : kept;
    out.rms = std::sqrt(sums.off / sums.count);
    out.expected_rms = std::sqrt(sums.expected / sums.count);
    out.noise_rms = std::sqrt(sums.noise / sums.count);
    out.median = procam::median(distances);
    out.inside_3_sigma = inside / count;
    out.outliers = outliers / count;
    return out;
  }
};

/// Distance of a point from the surface of a view, along the surface's normal; nullopt where the view does not see it.
std::optional<double> distance_from(const TrueView& truth, const ImageF& rays, const Vec3& point_in_world) {
  const Vec3 point = truth.world_from_camera.inverse() * point_in_world;
  if (!(point.z() > 1e-3)) return std::nullopt;
  const std::optional<Vec2> pixel = truth.camera.project(point);
  if (!pixel || !truth.camera.size.contains(*pixel)) return std::nullopt;
  const int x = std::clamp(int(std::lround(pixel->x())), 0, truth.depth.width() - 1),
            y = std::clamp(int(std::lround(pixel->y())), 0, truth.depth.height() - 1);
  const double here = double(truth.depth.at(x, y));
  if (!(here > 0)) return std::nullopt;
  // The true depth at the point itself, by the inverse depths of the pixels beside it.
  double inverse = 1 / here;
  for (const bool along_x : {true, false}) {
    const int dx = along_x, dy = !along_x;
    if (x - dx < 0 || y - dy < 0 || x + dx >= truth.depth.width() || y + dy >= truth.depth.height()) continue;
    const double before = double(truth.depth.at(x - dx, y - dy)),
                 after = double(truth.depth.at(x + dx, y + dy));
    if (!(before > 0 && after > 0) || std::abs(before - here) > kStep * here ||
        std::abs(after - here) > kStep * here)
      continue;
    inverse += (along_x ? pixel->x() - x : pixel->y() - y) * 0.5 * (1 / after - 1 / before);
  }
  const double off = depth_error(point.z() + here - 1 / inverse, truth.depth.view(), x, y);
  return std::abs(off) * along_normal(truth.depth.view(), rays, x, y);
}

}  // namespace

ScanError compare(const Scan& scan, ViewF true_depth) {
  require(true_depth.size() == scan.depth.size() && true_depth.channels == 1,
          "compare: the true depths have another size than the scan");
  const ImageF rays = pixel_rays(scan.camera.camera);
  ErrorSums sums;
  for (int y = 0; y < scan.depth.height(); ++y)
    for (int x = 0; x < scan.depth.width(); ++x) {
      if (!scan.measured(x, y) || !(true_depth.at(x, y) > 0)) continue;
      const double off = std::abs(depth_error(scan.depth.at(x, y), true_depth, x, y));
      const double sigma = scan.total_sigma(x, y), cosine = along_normal(true_depth, rays, x, y);
      sums.add(off * cosine, sigma * cosine, double(scan.sigma.at(x, y)) * cosine,
               off > 0.01 && off > 10 * sigma);
      sums.inside += off <= 3 * sigma;
    }
  return sums.error();
}

ScanError compare(const PointCloud& cloud, const std::vector<TrueView>& truth) {
  require(cloud.sigma.size() == cloud.points.size(), "compare: a cloud without standard deviations");
  std::vector<ImageF> rays;
  for (const TrueView& view : truth) {
    require(view.depth.size() == view.camera.size && view.depth.channels() == 1,
            "compare: the true depths have another size than their camera");
    rays.push_back(pixel_rays(view.camera));
  }
  ErrorSums sums;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < truth.size(); ++k)
      if (const std::optional<double> distance = distance_from(truth[k], rays[k], cloud.points[i]))
        nearest = std::min(nearest, *distance);
    if (!std::isfinite(nearest)) continue;
    const double sigma = cloud.sigma[i];
    sums.add(nearest, sigma, 0, nearest > 0.01 && nearest > 10 * sigma);
    sums.inside += nearest <= 3 * sigma;
  }
  return sums.error();
}

}  // namespace procam::scan
