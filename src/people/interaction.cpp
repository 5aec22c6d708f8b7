#include "procam/people/interaction.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "depth_inside.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/geometry/plane.hpp"

namespace procam::people {

SurfacePoint on_surface(const Vec3& point_in_sensor, const Pose& surface_from_sensor) {
  const Vec3 p = surface_from_sensor * point_in_sensor;
  return {p.head<2>(), -p.z()};
}

std::optional<Ray> pointing_ray(const Skeleton& person, Side side) {
  const std::optional<Vec3> head = head_of(person), hand = hand_of(person, side);
  if (!head || !hand || !((*hand - *head).norm() >= 0.2)) return std::nullopt;
  return Ray{*head, (*hand - *head).normalized()};
}

std::optional<Vec2> hit_on_surface(const Ray& ray_in_sensor, const Pose& surface_from_sensor) {
  const std::optional<Vec3> hit = intersect(surface_from_sensor * ray_in_sensor, Plane{Vec3::UnitZ(), 0});
  if (!hit) return std::nullopt;
  return Vec2(hit->head<2>());
}

double depth_inside(const Points2& polygon, const Vec2& point) {
  require(polygon.size() >= 3, "depth_inside: a polygon has at least 3 corners");
  bool is_inside = false;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Vec2 &a = polygon[j], &b = polygon[i];
    const Vec2 edge = b - a;
    const double length2 = edge.squaredNorm();
    const double s = length2 > 0 ? std::clamp((point - a).dot(edge) / length2, 0.0, 1.0) : 0.0;
    nearest = std::min(nearest, (point - a - s * edge).norm());
    if ((a.y() > point.y()) != (b.y() > point.y()) &&
        point.x() < a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
      is_inside = !is_inside;
  }
  return is_inside ? nearest : -nearest;
}

Zone::Zone(Points2 polygon, const ZoneOptions& options) : polygon_(std::move(polygon)), options_(options) {
  require(polygon_.size() >= 3, "Zone: a polygon has at least 3 corners");
  require(options.margin >= 0 && options.dwell >= 0 && options.patience >= 0, "ZoneOptions: negative");
}

Zone::Event Zone::update(const std::optional<Vec2>& point, double time) {
  bool stays = entered_ && time - seen_ <= options_.patience;
  if (point) {
    const double depth = depth_inside(polygon_, *point);
    seen_ = time;
    stays = entered_ && depth >= -options_.margin;
    if (!entered_ && depth >= options_.margin) {
      entered_ = time;
      has_dwelled_ = false;
      return Event::kEntered;
    }
  }
  if (!entered_) return Event::kNone;
  if (!stays) {
    entered_.reset();
    return Event::kLeft;
  }
  if (!has_dwelled_ && time - *entered_ >= options_.dwell) {
    has_dwelled_ = true;
    return Event::kDwelled;
  }
  return Event::kNone;
}

double Zone::progress(double time) const {
  if (!entered_) return 0;
  return options_.dwell > 0 ? std::clamp((time - *entered_) / options_.dwell, 0.0, 1.0) : 1;
}

std::optional<Vec2> trespass(const std::vector<TrackedPerson>& people, const Pose& surface_from_sensor,
                             const Points2& polygon, double height) {
  for (const TrackedPerson& person : people)
    for (const auto& seen : person.skeleton.joints) {
      if (!seen) continue;
      const SurfacePoint foot = on_surface(seen->position, surface_from_sensor);
      if (std::abs(foot.distance) < height && depth_inside(polygon, foot.point) >= 0) return foot.point;
    }
  return std::nullopt;
}

}  // namespace procam::people
