#include "surface_view.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "procam/core/base/parallel.hpp"

namespace procam::scan {
namespace {

constexpr int kPlaneReach = 8;           // pixels: planes are fitted to 17 x 17
constexpr int kPointReach = 2;           // and their points to 5 x 5 of these
constexpr double kMinMeasured = 0.6;     // of these
constexpr double kMaxResidual = 0.5e-3;  // metres, and three standard deviations
constexpr int kSums = 10;

/// 1, a, b, aa, ab, bb, w, wa, wb, ww of all measured pixels above and to the left, where w is the inverse depth of the ray (a, b, 1).
class RaySums {
 public:
  RaySums(const Scan& scan, const ImageF& rays)
      : width_(scan.depth.width() + 1),
        sums_(std::size_t(width_) * std::size_t(scan.depth.height() + 1), Sums{}) {
    for (int y = 0; y < scan.depth.height(); ++y) {
      Sums row{};
      for (int x = 0; x < scan.depth.width(); ++x) {
        const double z = double(scan.depth.at(x, y)), a = double(rays.at(x, y, 0)),
                     b = double(rays.at(x, y, 1));
        if (z > 0 && std::isfinite(a + b)) {
          const double w = 1 / z;
          const Sums pixel{1, a, b, a * a, a * b, b * b, w, w * a, w * b, w * w};
          for (std::size_t i = 0; i < kSums; ++i) row[i] += pixel[i];
        }
        const Sums& above = at(x + 1, y);
        for (std::size_t i = 0; i < kSums; ++i) at(x + 1, y + 1)[i] = row[i] + above[i];
      }
    }
  }

  using Sums = std::array<double, kSums>;
  Sums window(int left, int top, int right, int bottom) const {
    Sums out;
    for (std::size_t i = 0; i < kSums; ++i)
      out[i] =
          at(right + 1, bottom + 1)[i] - at(left, bottom + 1)[i] - at(right + 1, top)[i] + at(left, top)[i];
    return out;
  }

 private:
  Sums& at(int x, int y) { return sums_[std::size_t(y) * std::size_t(width_) + std::size_t(x)]; }
  const Sums& at(int x, int y) const { return sums_[std::size_t(y) * std::size_t(width_) + std::size_t(x)]; }
  int width_;
  std::vector<Sums> sums_;
};

/// n with n . (a, b, 1) = w about the ray (a0, b0): its slopes by least squares over the window `s`, its distance over the smaller
/// window `inner`, so that curved surfaces are not drawn inwards. nullopt where it is no plane.
std::optional<Vec3> fit_plane(const RaySums::Sums& s, const RaySums::Sums& inner, double a0, double b0,
                              double max_residual) {
  const double n = s[0], a = s[1] - n * a0, b = s[2] - n * b0;
  const double aa = s[3] - 2 * a0 * s[1] + n * a0 * a0, bb = s[5] - 2 * b0 * s[2] + n * b0 * b0,
               ab = s[4] - a0 * s[2] - b0 * s[1] + n * a0 * b0;
  Mat3 normal;
  normal << aa, ab, a, ab, bb, b, a, b, n;
  const Vec3 right(s[7] - a0 * s[6], s[8] - b0 * s[6], s[6]);
  const Vec3 t = normal.ldlt().solve(right);
  const double w = t.z(), squares = s[9] - t.dot(right);
  if (!t.allFinite() || !(w > 1e-3)) return std::nullopt;
  const double residual = std::sqrt(std::max(squares, 0.0) / n) / (w * w);
  if (residual > max_residual) return std::nullopt;
  const double at_ray =
      (inner[6] - t.x() * (inner[1] - inner[0] * a0) - t.y() * (inner[2] - inner[0] * b0)) / inner[0];
  if (!(at_ray > 1e-3)) return std::nullopt;
  return Vec3(t.x(), t.y(), at_ray - t.x() * a0 - t.y() * b0);
}

}  // namespace

SurfaceView::SurfaceView(const Scan& scan, int threads)
    : scan_(&scan),
      camera_from_rig_(scan.camera.rig_from_camera.inverse()),
      rays_(pixel_rays(scan.camera.camera, threads)),
      planes_(scan.depth.size(), 3) {
  const int width = scan.depth.width(), height = scan.depth.height();
  const RaySums sums(scan, rays_);
  parallel_each(height, threads, [&](int y) {
    for (int x = 0; x < width; ++x) {
      if (!scan.measured(x, y)) continue;
      const int left = std::max(0, x - kPlaneReach), right = std::min(width - 1, x + kPlaneReach);
      const int top = std::max(0, y - kPlaneReach), bottom = std::min(height - 1, y + kPlaneReach);
      const RaySums::Sums window = sums.window(left, top, right, bottom);
      const RaySums::Sums inner =
          sums.window(std::max(0, x - kPointReach), std::max(0, y - kPointReach),
                      std::min(width - 1, x + kPointReach), std::min(height - 1, y + kPointReach));
      constexpr int kWhole = (2 * kPlaneReach + 1) * (2 * kPlaneReach + 1);
      if (window[0] < kMinMeasured * kWhole) continue;
      const std::optional<Vec3> plane =
          fit_plane(window, inner, double(rays_.at(x, y, 0)), double(rays_.at(x, y, 1)),
                    3 * double(scan.sigma.at(x, y)) + kMaxResidual);
      if (!plane) continue;
      for (int c = 0; c < 3; ++c) planes_.at(x, y, c) = float((*plane)[c]);
    }
  });
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) plane_count_ += has_plane(x, y);
}

SurfacePoint SurfaceView::at(int x, int y) const {
  const Vec3 ray = this->ray(x, y);
  const Vec3 plane(planes_.at(x, y, 0), planes_.at(x, y, 1), planes_.at(x, y, 2));
  const double length = plane.norm();
  SurfacePoint out;
  out.depth = 1 / plane.dot(ray);
  out.pixel = Vec2(x, y);
  const Pose& rig_from_camera = scan_->camera.rig_from_camera;
  out.point = rig_from_camera * Vec3(ray * out.depth);
  out.normal = rig_from_camera.rotate(Vec3(-plane / length));
  // d . n moves along the normal with the depth.
  out.sigma = double(scan_->sigma.at(x, y)) * std::abs(plane.dot(ray)) / length;
  return out;
}

std::optional<Eigen::Vector2i> SurfaceView::pixel_of(const Vec3& point_in_rig) const {
  const Vec3 point = camera_from_rig_ * point_in_rig;
  if (!(point.z() > 1e-3)) return std::nullopt;
  const std::optional<Vec2> pixel = scan_->camera.camera.project(point);
  if (!pixel) return std::nullopt;
  if (!(pixel->x() > -0.5 && pixel->y() > -0.5 && pixel->x() < scan_->depth.width() - 0.5 &&
        pixel->y() < scan_->depth.height() - 0.5))
    return std::nullopt;
  return Eigen::Vector2i(int(std::lround(pixel->x())), int(std::lround(pixel->y())));
}

std::vector<StationView::Sample> StationView::samples(int count) const {
  int all = 0;
  for (const SurfaceView& view : views) all += view.plane_count();
  const int step = std::max(2, int(std::ceil(std::sqrt(double(all) / std::max(count, 1)))));
  std::vector<Sample> out;
  for (int i = 0; i < int(views.size()); ++i) {
    const SurfaceView& view = views[std::size_t(i)];
    const ImageSize size = view.scan().depth.size();
    for (int y = step / 2; y < size.height; y += step)
      for (int x = step / 2; x < size.width; x += step)
        if (view.has_plane(x, y)) out.push_back({i, view.at(x, y)});
  }
  return out;
}

std::vector<StationView> station_views(const std::vector<Station>& stations, int threads) {
  std::vector<StationView> views(stations.size());
  for (std::size_t s = 0; s < stations.size(); ++s)
    for (const Scan& scan : stations[s].scans) views[s].views.emplace_back(scan, threads);
  return views;
}

}  // namespace procam::scan
