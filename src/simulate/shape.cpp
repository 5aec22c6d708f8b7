#include "shape.hpp"

#include <algorithm>

namespace procam::simulate::internal {
namespace {

Rectangle bounds_of(const Polygon& polygon) {
  Rectangle bounds{polygon.corners.front(), polygon.corners.front()};
  for (const Vec2& corner : polygon.corners) {
    bounds.low = bounds.low.cwiseMin(corner);
    bounds.high = bounds.high.cwiseMax(corner);
  }
  return bounds;
}

ShapeUv uv_on(const Rectangle& r, const Spot& spot) {
  const Vec3& p = spot.point;
  const Vec2 scale = (r.high - r.low).cwiseInverse();
  ShapeUv at;
  at.uv = (p.head<2>() - r.low).cwiseProduct(scale);
  at.uv_by_point << scale.x(), 0, 0, 0, scale.y(), 0;
  return at;
}
ShapeUv uv_on(const Polygon& polygon, const Spot& spot) {
  return uv_on(bounds_of(polygon), spot);
}
/// How the longitude grows with the point.
Eigen::RowVector3d turn(const Vec3& p) {
  return Eigen::RowVector3d(-p.y(), p.x(), 0) / std::max(p.x() * p.x() + p.y() * p.y(), 1e-18);
}
ShapeUv uv_on(const Sphere& sphere, const Spot& spot) {
  const Vec3& p = spot.point;
  const double span = sphere.latitude.to - sphere.latitude.from;
  ShapeUv at;
  at.uv = Vec2(share_of(sphere.longitude, longitude_of(p)),
               (std::asin(std::clamp(p.z() / sphere.radius, -1.0, 1.0)) - sphere.latitude.from) / span);
  at.uv_by_point.row(0) = turn(p) / (sphere.longitude.to - sphere.longitude.from);
  at.uv_by_point.row(1) = Eigen::RowVector3d(0, 0, 1) / (std::max(std::hypot(p.x(), p.y()), 1e-9) * span);
  return at;
}
ShapeUv uv_on(const Cylinder& cylinder, const Spot& spot) {
  const Vec3& p = spot.point;
  const double height = cylinder.high - cylinder.low;
  ShapeUv at;
  at.uv = Vec2(share_of(cylinder.longitude, longitude_of(p)), (p.z() - cylinder.low) / height);
  at.uv_by_point.row(0) = turn(p) / (cylinder.longitude.to - cylinder.longitude.from);
  at.uv_by_point.row(1) = Eigen::RowVector3d(0, 0, 1 / height);
  return at;
}
ShapeUv uv_on(const TriangleMesh& shape, const Spot& spot) {
  const std::size_t corner = std::size_t(shape.tree().corners(spot.facet)[0]);
  ShapeUv at;
  at.uv_by_point = shape.tree().uv_by_point(spot.facet);
  at.uv = shape.mesh().uv[corner] + at.uv_by_point * (spot.point - shape.mesh().vertices[corner]);
  return at;
}

Points3 block(const Vec3& low, const Vec3& high) {
  Points3 corners;
  for (int i = 0; i < 8; ++i)
    corners.emplace_back(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z());
  return corners;
}
Points3 hull_on(const Rectangle& r) {
  return {Vec3(r.low.x(), r.low.y(), 0), Vec3(r.high.x(), r.low.y(), 0), Vec3(r.high.x(), r.high.y(), 0),
          Vec3(r.low.x(), r.high.y(), 0)};
}
Points3 hull_on(const Polygon& polygon) {
  return hull_on(bounds_of(polygon));
}
Points3 hull_on(const Sphere& sphere) {
  return block(Vec3::Constant(-sphere.radius), Vec3::Constant(sphere.radius));
}
Points3 hull_on(const Cylinder& c) {
  std::vector<double> longitudes = {c.longitude.from, c.longitude.to};  // and the outermost points between
  for (int quarter = -4; quarter <= 4; ++quarter)
    if (quarter * M_PI_2 > c.longitude.from && quarter * M_PI_2 < c.longitude.to)
      longitudes.push_back(quarter * M_PI_2);
  Vec3 low(c.radius, c.radius, c.low), high(-c.radius, -c.radius, c.high);
  for (const double longitude : longitudes) {
    const Vec2 rim = c.radius * Vec2(std::cos(longitude), std::sin(longitude));
    low.head<2>() = low.head<2>().cwiseMin(rim);
    high.head<2>() = high.head<2>().cwiseMax(rim);
  }
  return block(low, high);
}
Points3 hull_on(const TriangleMesh& shape) {
  return block(shape.tree().bounds().min(), shape.tree().bounds().max());
}

bool is_arc(const Arc& arc) {
  return arc.from < arc.to && arc.from >= -2 * M_PI && arc.to <= arc.from + 2 * M_PI + 1e-12 &&
         arc.to <= 2 * M_PI;
}
bool has_extent(const Rectangle& r) {
  return (r.high - r.low).minCoeff() > 0;
}
bool has_extent(const Polygon& polygon) {
  return polygon.corners.size() >= 3 && has_extent(bounds_of(polygon));
}
bool has_extent(const Sphere& sphere) {
  return sphere.radius > 0 && is_arc(sphere.longitude) && sphere.latitude.from < sphere.latitude.to &&
         sphere.latitude.from >= -M_PI_2 && sphere.latitude.to <= M_PI_2;
}
bool has_extent(const Cylinder& cylinder) {
  return cylinder.radius > 0 && cylinder.low < cylinder.high && is_arc(cylinder.longitude);
}
bool has_extent(const TriangleMesh&) {
  return true;  // checked when it was made
}

}  // namespace

ShapeUv uv_of(const Shape& shape, const Spot& spot) {
  return std::visit([&](const auto& s) { return uv_on(s, spot); }, shape);
}

bool is_there(const Body& body, const Spot& spot) {
  if (!body.cutout) return true;
  const Cutout& cutout = *body.cutout;
  const Vec3 q = cutout.mask_from_uv * uv_of(body.shape, spot).uv.homogeneous();
  if (!(q.z() > 0)) return false;
  const ImageU8& mask = cutout.mask;
  const double x = std::clamp(q.x() / q.z() * mask.width() - 0.5, 0.0, mask.width() - 1.0);
  const double y = std::clamp(q.y() / q.z() * mask.height() - 0.5, 0.0, mask.height() - 1.0);
  const int x0 = int(x), y0 = int(y);
  const int x1 = std::min(x0 + 1, mask.width() - 1), y1 = std::min(y0 + 1, mask.height() - 1);
  const double s = x - x0, t = y - y0;
  return (1 - t) * ((1 - s) * mask.at(x0, y0) + s * mask.at(x1, y0)) +
             t * ((1 - s) * mask.at(x0, y1) + s * mask.at(x1, y1)) >=
         127.5;
}

std::optional<Rectangle> flat_bounds(const Shape& shape) {
  if (const auto* rectangle = std::get_if<Rectangle>(&shape)) return *rectangle;
  if (const auto* polygon = std::get_if<Polygon>(&shape)) return bounds_of(*polygon);
  return std::nullopt;
}

bool is_convex(const Shape& shape) {
  const auto* polygon = std::get_if<Polygon>(&shape);
  if (polygon == nullptr) return std::holds_alternative<Rectangle>(shape);
  const Points2& c = polygon->corners;
  bool left = false, right = false;
  for (std::size_t i = 0; i < c.size(); ++i) {
    const Vec2 along = c[(i + 1) % c.size()] - c[i], next = c[(i + 2) % c.size()] - c[(i + 1) % c.size()];
    const double turn = along.x() * next.y() - along.y() * next.x();
    left = left || turn < 0;
    right = right || turn > 0;
  }
  return !(left && right);
}

Points3 hull_of(const Shape& shape) {
  return std::visit([](const auto& s) { return hull_on(s); }, shape);
}

void check_body(const Body& body) {
  require(std::visit([](const auto& s) { return has_extent(s); }, body.shape),
          "simulate: body '" + body.name + "' has no extent, or an arc that is empty or more than a turn");
  require(body.gloss.share >= 0 && body.gloss.share <= 1 && body.gloss.spread > 0 &&
              (body.gloss.share == 0 || flat_bounds(body.shape)),
          "simulate: the gloss of body '" + body.name +
              "' is not in 0..1, has no spread, or the body is not flat");
  require(!body.cutout || (!body.cutout->mask.empty() && body.cutout->mask.channels() == 1 &&
                           body.cutout->mask_from_uv.allFinite()),
          "simulate: the cutout of body '" + body.name + "' has no mask of one channel, or is not finite");
}

}  // namespace procam::simulate::internal
