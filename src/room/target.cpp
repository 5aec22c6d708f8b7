#include "target.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "procam/core/base/error.hpp"

namespace procam::room {
namespace {

int position_of(const RoomPoints& points, const KnownTarget::View& view) {
  for (std::size_t i = 0; i < points.positions.size(); ++i)
    if (points.positions[i].view == view.view &&
        points.cameras[std::size_t(points.positions[i].camera)].name == view.camera)
      return int(i);
  throw Error(ErrorKind::kInput, "camera '" + view.camera + "' in view '" + view.view + "'",
              "the session has no such position", "give the views of the session that see the target");
}

struct Ray {
  Vec3 from, direction;
  double focal = 1;
};

}  // namespace

double extent(const Points3& points) {
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p / double(points.size());
  double sum = 0;
  for (const Vec3& p : points) sum += (p - mean).squaredNorm();
  return std::sqrt(sum);
}

std::optional<SeenTarget> see_target(const RoomPoints& points, const RoomState& state,
                                     const KnownTarget& target) {
  std::vector<std::vector<Ray>> rays(target.places.size());
  for (const KnownTarget::View& view : target.views) {
    const auto position = std::size_t(position_of(points, view));
    const Camera& lens = state.lenses[std::size_t(points.positions[position].camera)];
    const Pose& place = state.rig_from_device[position];
    for (std::size_t i = 0; i < view.points.size(); ++i)
      if (const std::optional<Vec3> bearing = lens.unproject(view.pixels[i]))
        rays[std::size_t(view.points[i])].push_back(
            {place.translation, (place.rotation * *bearing).normalized(), lens.intrinsics.fx});
  }
  SeenTarget out;
  double square = 0;
  int rows = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (rays[i].size() < 2) continue;
    Mat3 sum = Mat3::Zero();
    Vec3 right = Vec3::Zero();
    for (const Ray& ray : rays[i]) {
      const Mat3 across = Mat3::Identity() - ray.direction * ray.direction.transpose();
      sum += across;
      right += across * ray.from;
    }
    const Eigen::FullPivLU<Mat3> solver(sum);
    if (!solver.isInvertible()) continue;
    const Vec3 at = solver.solve(right);
    for (const Ray& ray : rays[i]) {
      const Vec3 to = at - ray.from;
      const double depth = to.dot(ray.direction);
      square += (to - depth * ray.direction).squaredNorm() * std::pow(ray.focal / std::max(depth, 1e-9), 2);
      rows += 2;
    }
    rows -= 3;
    out.places.push_back(target.places[i]);
    out.points.push_back(at);
  }
  if (out.points.size() < 2 || !(extent(out.points) > 0)) return std::nullopt;
  out.rms_px = std::sqrt(square / std::max(1, rows));
  return out;
}

double size_variance(const RoomPoints& points, const RoomState& state, const KnownTarget& target) {
  const auto size = [&](const KnownTarget& moved) {
    const std::optional<SeenTarget> seen = see_target(points, state, moved);
    return seen ? std::log(extent(seen->points)) : 0.0;
  };
  double variance = target.size_sigma * target.size_sigma;
  KnownTarget moved = target;
  constexpr double kStep = 0.01;
  for (std::size_t v = 0; v < target.views.size(); ++v)
    for (Vec2& pixel : moved.views[v].pixels)
      for (int c = 0; c < 2; ++c) {
        const double at = pixel[c];
        pixel[c] = at + kStep;
        const double up = size(moved);
        pixel[c] = at - kStep;
        const double down = size(moved);
        pixel[c] = at;
        variance += std::pow((up - down) / (2 * kStep) * target.views[v].sigma, 2);
      }
  return variance;
}

}  // namespace procam::room
