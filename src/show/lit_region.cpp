#include "lit_region.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "procam/core/geometry/convex.hpp"
#include "procam/core/geometry/plane.hpp"

namespace procam::show {
namespace {

constexpr int kSamplesOfSide = 8;  ///< a side of the frame is curved on the surface
constexpr double kMuchLess = 0.5;  ///< share of the region's area: the robot has come nearer

Vec2 middle_of(const Points2& polygon) {
  Vec2 sum = Vec2::Zero();
  for (const Vec2& corner : polygon) sum += corner;
  return sum / double(polygon.size());
}

Points2 enlarged(Points2 polygon, double factor) {
  const Vec2 middle = middle_of(polygon);
  for (Vec2& corner : polygon) corner = middle + factor * (corner - middle);
  return polygon;
}

bool is_inside(const Points2& inner, const Points2& outer) {
  const std::vector<HalfPlane> sides = half_planes(outer);
  return std::all_of(inner.begin(), inner.end(), [&](const Vec2& point) {
    return std::all_of(sides.begin(), sides.end(),
                       [&](const HalfPlane& side) { return side.normal.dot(point) <= side.offset; });
  });
}

std::optional<Vec2> lit_point(const Projector& projector, const Pose& surface_from_projector,
                              const Vec2& pixel) {
  const std::optional<Ray> ray = projector.emit(pixel);
  if (!ray) return std::nullopt;
  const std::optional<Vec3> lit = intersect(surface_from_projector * *ray, Plane::of_xy(Pose()));
  if (!lit) return std::nullopt;
  return Vec2(lit->head<2>());
}

}  // namespace

Points2 reached_region(const Projector& projector, const PlacedPlane& plane) {
  Points2 region;
  for (const Vec2& corner : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)}) {
    const Vec3 at = plane.plane_from_content * corner.homogeneous();
    if (!(at.z() > 0)) return {};
    region.push_back(at.hnormalized());
  }
  if (area(region) < 0) std::reverse(region.begin(), region.end());
  const ImageSize size = projector.size();
  // The outer edges of the frame's pixels.
  const std::array<Vec2, 4> corners = {Vec2(-0.5, -0.5), Vec2(size.width - 0.5, -0.5),
                                       Vec2(size.width - 0.5, size.height - 0.5),
                                       Vec2(-0.5, size.height - 0.5)};
  const Pose surface_from_projector = plane.projector_from_surface.inverse();
  const auto centre = lit_point(projector, surface_from_projector, 0.5 * (corners[0] + corners[2]));
  if (!centre) return {};
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec2 from = corners[i], to = corners[(i + 1) % 4];
    Points2 side;
    for (int k = 0; k <= kSamplesOfSide; ++k) {
      const auto lit =
          lit_point(projector, surface_from_projector, from + double(k) / kSamplesOfSide * (to - from));
      if (!lit) return {};
      side.push_back(*lit);
    }
    const Vec2 along = side.back() - side.front();
    if (!(along.norm() > 0)) return {};
    HalfPlane within{Vec2(along.y(), -along.x()).normalized(), -INFINITY};
    if (within.normal.dot(*centre - side.front()) > 0) within.normal = -within.normal;
    for (const Vec2& point : side) within.offset = std::max(within.offset, within.normal.dot(point));
    region = clipped(region, within);
    if (region.size() < 3) return {};
  }
  return area(region) > 1e-9 ? region : Points2();
}

const Points2& AnnouncedRegion::follow(const Points2& reached, double time) {
  const bool stays = !reached.empty() && !tried_.empty() && is_inside(enlarged(reached, kKept), tried_) &&
                     area(reached) > kMuchLess * area(tried_);
  if (!stays) {
    announced_.clear();
    tried_ = reached.empty() ? Points2() : enlarged(reached, kEnlarged);
    since_ = time;
  } else if (announced_.empty() && time - since_ >= kStandsFor) {
    announced_ = tried_;
  }
  return announced_;
}

}  // namespace procam::show
