#pragma once
/// Shapes and rays, in the shape's own frame.
#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "mesh_tree.hpp"
#include "procam/simulate/room.hpp"

namespace procam::simulate::internal {

/// A point of a shape, and of a mesh the facet that it lies on.
struct Spot {
  Vec3 point = Vec3::Zero();
  int facet = -1;
};

/// s is infinite where nothing is met.
struct Meeting {
  double s = std::numeric_limits<double>::infinity();
  Spot spot = {};

  bool met() const { return s < std::numeric_limits<double>::infinity(); }
};

/// Share of the arc that lies before an angle: 0..1 inside it, more than 1 outside.
inline double share_of(const Arc& arc, double angle) {
  double beyond = angle - arc.from;
  if (beyond < 0) beyond += 2 * M_PI;
  if (beyond >= 2 * M_PI) beyond -= 2 * M_PI;
  return beyond / (arc.to - arc.from);
}
inline double longitude_of(const Vec3& p) {
  return std::atan2(p.y(), p.x());
}
inline bool is_whole(const Arc& longitude) {
  return longitude.to - longitude.from >= 2 * M_PI;
}

/// Is the shape there, at a point of its plane, sphere or tube?
inline bool covers(const Rectangle& r, double x, double y) {
  return x >= r.low.x() && y >= r.low.y() && x <= r.high.x() && y <= r.high.y();
}
inline bool covers(const Polygon& polygon, double x, double y) {
  bool inside = false;  // an odd number of edges to the right
  const Points2& c = polygon.corners;
  for (std::size_t i = 0, j = c.size() - 1; i < c.size(); j = i++)
    if ((c[i].y() > y) != (c[j].y() > y) &&
        x < c[i].x() + (c[j].x() - c[i].x()) * (y - c[i].y()) / (c[j].y() - c[i].y()))
      inside = !inside;
  return inside;
}
inline bool covers(const Sphere& sphere, const Vec3& p) {
  if (!is_whole(sphere.longitude) && share_of(sphere.longitude, longitude_of(p)) > 1) return false;
  return p.z() >= sphere.radius * std::sin(sphere.latitude.from) &&
         p.z() <= sphere.radius * std::sin(sphere.latitude.to);
}
inline bool covers(const Cylinder& cylinder, const Vec3& p) {
  if (!(p.z() >= cylinder.low && p.z() <= cylinder.high)) return false;
  return is_whole(cylinder.longitude) || share_of(cylinder.longitude, longitude_of(p)) <= 1;
}

/// The first point eye + s * direction on the shape with from < s < to.
template <typename Flat>
Meeting meet_flat(const Flat& shape, const Vec3& eye, const Vec3& direction, double from, double to) {
  const double s = -eye.z() / direction.z();
  if (!(s > from && s < to)) return {};
  const double x = eye.x() + s * direction.x(), y = eye.y() + s * direction.y();
  if (!covers(shape, x, y)) return {};
  return {s, {Vec3(x, y, 0)}};
}
/// a s^2 + 2 b s + c = 0.
struct Quadratic {
  double a, b, c;
};
/// Both roots, the nearer first.
template <typename Round>
Meeting meet_round(const Round& shape, const Quadratic& equation, const Vec3& eye, const Vec3& direction,
                   double from, double to) {
  const auto [a, b, c] = equation;
  const double discriminant = b * b - a * c;
  if (!(discriminant > 0 && a > 0)) return {};
  const double root = std::sqrt(discriminant);
  for (const double s : {(-b - root) / a, (-b + root) / a}) {
    if (!(s > from && s < to)) continue;
    const Vec3 point = eye + s * direction;
    if (covers(shape, point)) return {s, {point}};
  }
  return {};
}

inline Meeting meet(const Rectangle& shape, const Vec3& eye, const Vec3& d, double from, double to) {
  return meet_flat(shape, eye, d, from, to);
}
inline Meeting meet(const Polygon& shape, const Vec3& eye, const Vec3& d, double from, double to) {
  return meet_flat(shape, eye, d, from, to);
}
inline Meeting meet(const Sphere& shape, const Vec3& eye, const Vec3& d, double from, double to) {
  return meet_round(shape, {d.squaredNorm(), eye.dot(d), eye.squaredNorm() - shape.radius * shape.radius},
                    eye, d, from, to);
}
inline Meeting meet(const Cylinder& shape, const Vec3& eye, const Vec3& d, double from, double to) {
  const Vec2 e = eye.head<2>(), flat = d.head<2>();
  return meet_round(shape, {flat.squaredNorm(), e.dot(flat), e.squaredNorm() - shape.radius * shape.radius},
                    eye, d, from, to);
}
inline Meeting meet(const TriangleMesh& shape, const Vec3& eye, const Vec3& d, double from, double to) {
  const MeshTree::Found found = shape.tree().first(eye, d, from, to);
  if (found.facet < 0) return {};
  return {found.s, {eye + found.s * d, found.facet}};
}
inline Meeting meet(const Shape& shape, const Vec3& eye, const Vec3& d, double from, double to) {
  if (const auto* rectangle = std::get_if<Rectangle>(&shape)) return meet(*rectangle, eye, d, from, to);
  return std::visit([&](const auto& s) { return meet(s, eye, d, from, to); }, shape);
}

/// Unit normal of the painted side at a spot of the shape.
inline Vec3 outward(const Shape& shape, const Spot& spot) {
  const Vec3& p = spot.point;
  if (std::holds_alternative<Sphere>(shape)) return p.normalized();
  if (std::holds_alternative<Cylinder>(shape)) return Vec3(p.x(), p.y(), 0).normalized();
  if (const auto* mesh = std::get_if<TriangleMesh>(&shape)) return mesh->tree().normal(spot.facet);
  return Vec3(0, 0, -1);
}
/// Of the surface that light falls on: of a mesh, the one that its facets stand for.
inline Vec3 smooth_outward(const Shape& shape, const Spot& spot) {
  const auto* mesh = std::get_if<TriangleMesh>(&shape);
  return mesh ? mesh->tree().smooth_normal(spot.facet, spot.point) : outward(shape, spot);
}

/// u and v at a point of the shape, and how they grow with it.
struct ShapeUv {
  Vec2 uv;
  Mat23 uv_by_point;
};
ShapeUv uv_of(const Shape& shape, const Spot& spot);

/// Is the body there, at a spot of its shape?
bool is_there(const Body& body, const Spot& spot);

/// The first point eye + s * direction on the body with from < s < to.
inline Meeting meet(const Body& body, const Vec3& eye, const Vec3& d, double from, double to) {
  Meeting met = meet(body.shape, eye, d, from, to);
  while (met.met() && !is_there(body, met.spot)) met = meet(body.shape, eye, d, met.s * (1 + 1e-12), to);
  return met;
}

/// The rectangle round a flat shape, the shape itself if it is one; nullopt of round shapes.
std::optional<Rectangle> flat_bounds(const Shape& shape);

/// Of a flat shape: does it hold the line between any two of its points?
bool is_convex(const Shape& shape);

/// Corners of a convex body round the shape.
Points3 hull_of(const Shape& shape);

/// Throws std::invalid_argument for a shape without extent, an arc out of range, or a cutout without a mask.
void check_body(const Body& body);

}  // namespace procam::simulate::internal
