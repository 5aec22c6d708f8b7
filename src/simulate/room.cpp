#include "procam/simulate/room.hpp"

#include <Eigen/LU>

#include "caster.hpp"
#include "marker_print.hpp"
#include "room_hit.hpp"

namespace procam::simulate {
namespace {

struct PointAt {
  Vec2 uv;

  static double along(const Arc& arc, double share) { return arc.from + share * (arc.to - arc.from); }
  Vec3 operator()(const Rectangle& r) const {
    const Vec2 p = r.low + uv.cwiseProduct(r.high - r.low);
    return Vec3(p.x(), p.y(), 0);
  }
  Vec3 operator()(const Polygon& polygon) const {
    const Points3 bounds = internal::hull_of(Shape(polygon));
    return bounds[0] + Vec3(uv.x(), uv.y(), 0).cwiseProduct(bounds[2] - bounds[0]);
  }
  Vec3 operator()(const Sphere& s) const {
    const double longitude = along(s.longitude, uv.x()), latitude = along(s.latitude, uv.y());
    return s.radius * Vec3(std::cos(latitude) * std::cos(longitude), std::cos(latitude) * std::sin(longitude),
                           std::sin(latitude));
  }
  Vec3 operator()(const Cylinder& c) const {
    const double longitude = along(c.longitude, uv.x());
    return Vec3(c.radius * std::cos(longitude), c.radius * std::sin(longitude),
                c.low + uv.y() * (c.high - c.low));
  }
  Vec3 operator()(const TriangleMesh& shape) const {
    const Mesh& mesh = shape.mesh();
    for (const std::array<int, 3>& triangle : mesh.triangles) {
      const auto at = [&](std::size_t k) -> const Vec2& { return mesh.uv[std::size_t(triangle[k])]; };
      Mat2 uv_by_sides;
      uv_by_sides << at(1) - at(0), at(2) - at(0);
      const Vec2 b = uv_by_sides.inverse() * (uv - at(0));  // not finite where u, v have no area
      if (!(b.minCoeff() >= -1e-9 && b.sum() <= 1 + 1e-9)) continue;
      const auto corner = [&](std::size_t k) { return mesh.vertices[std::size_t(triangle[k])]; };
      return (1 - b.sum()) * corner(0) + b.x() * corner(1) + b.y() * corner(2);
    }
    throw std::invalid_argument("point_at: no triangle of the mesh has these u, v");
  }
};

}  // namespace

int Room::index_of(const std::string& name) const {
  std::string known;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].name == name) return int(i);
    known += (known.empty() ? "" : ", ") + bodies[i].name;
  }
  throw Error(ErrorKind::kInput, "body '" + name + "'", "the room has none of that name",
              known.empty() ? "add bodies to the room" : "name one of: " + known);
}

TriangleMesh::TriangleMesh(std::shared_ptr<const Mesh> mesh) {
  require(mesh != nullptr, "TriangleMesh: there is no mesh");
  if (const auto fault = fault_of(*mesh))
    throw Error(ErrorKind::kInput, "a body of triangles", *fault, "correct the mesh");
  tree_ = std::make_shared<const internal::MeshTree>(std::move(mesh));
}

const Mesh& TriangleMesh::mesh() const {
  return tree_->mesh();
}

std::optional<RoomHit> nearest_hit(const Room& room, const Ray& ray_in_room) {
  RoomHit nearest;
  internal::Spot spot;
  for (const bool backdrop : {false, true}) {
    double limit = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < room.bodies.size(); ++i) {
      const Body& body = room.bodies[i];
      if (body.backdrop != backdrop) continue;
      internal::check_body(body);
      const Ray ray = body.room_from_body.inverse() * ray_in_room;
      const internal::Meeting met = internal::meet(body, ray.origin, ray.direction, 0, limit);
      if (!met.met()) continue;
      nearest.body = int(i);
      nearest.lengths = met.s;
      spot = met.spot;
      limit = met.s * (1 + 1e-7);
    }
    if (!std::isfinite(limit)) continue;
    const Body& body = room.bodies[std::size_t(nearest.body)];
    const Vec3 outward = body.room_from_body.rotate(internal::outward(body.shape, spot));
    nearest.front = outward.dot(ray_in_room.direction) < 0;
    nearest.normal_in_room = nearest.front ? outward : Vec3(-outward);
    nearest.point_in_room = body.room_from_body * spot.point;
    nearest.uv = internal::uv_of(body.shape, spot).uv;
    return nearest;
  }
  return std::nullopt;
}

Vec3 point_at(const Body& body, const Vec2& uv) {
  require(uv.minCoeff() >= 0 && uv.maxCoeff() <= 1, "point_at: u or v outside 0..1");
  internal::check_body(body);
  return body.room_from_body * std::visit(PointAt{uv}, body.shape);
}

std::vector<Body> box(const std::string& name, const Pose& room_from_box, const Vec3& size,
                      const Paint& paint) {
  require(size.minCoeff() > 0, "box: a side of '" + name + "' is not positive");
  std::vector<Body> faces;
  for (int axis = 0; axis < 3; ++axis)
    for (const bool far_side : {false, true}) {
      // z of the face points into the block; x, y, z right-handed.
      const int x = (axis + (far_side ? 2 : 1)) % 3, y = (axis + (far_side ? 1 : 2)) % 3;
      Mat3 box_from_face;
      box_from_face << Vec3::Unit(x), Vec3::Unit(y), (far_side ? -1.0 : 1.0) * Vec3::Unit(axis);
      const Vec3 corner = far_side ? Vec3(size[axis] * Vec3::Unit(axis)) : Vec3(Vec3::Zero());
      faces.push_back({name + (far_side ? " +" : " -") + "xyz" [axis],
                       Rectangle { Vec2::Zero(), Vec2(size[x], size[y]) },
                       room_from_box * Pose(box_from_face, corner), paint});
    }
  return faces;
}

Body printed_sheet(const std::string& name, const PrintedBoard& board, const Pose& room_from_board) {
  const Points3 corners = sheet_corners_in_board(board);
  return {name, Rectangle{corners[0].head<2>(), corners[2].head<2>()}, room_from_board, board,
          board.white_albedo};
}

Body marker_sheet(const PlacedMarker& marker, const MarkerCells& codes, const Pose& room_from_world,
                  int rim_cells) {
  require(marker.size > 0 && rim_cells >= 0, "marker_sheet: the marker's size or rim is not positive");
  require(marker.id >= 0 && std::size_t(marker.id) < codes.white.size(),
          "marker_sheet: there is no marker " + std::to_string(marker.id));
  Texture print;
  print.image = internal::marker_print(marker.id, codes, rim_cells);
  const int cells = print.image.width();
  const Vec2 corner = Vec2::Constant(0.5 * marker.size * cells / (cells - 2 * rim_cells));
  const double white = print.white;
  return {"marker " + std::to_string(marker.id), Rectangle{-corner, corner},
          room_from_world * marker.world_from_marker, std::move(print), white};
}

}  // namespace procam::simulate
