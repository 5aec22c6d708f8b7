#include "procam/render/viewpoint.hpp"

#include <Eigen/LU>
#include <algorithm>

namespace procam::render {

namespace {

constexpr double kSeenRound = 0.2;  ///< of a plane's size, seen round it on each side
constexpr double kMeshRound = 1.1;  ///< what is seen of a mesh's place, over its reach from its middle

/// A surface as somebody who looks for a place to stand sees it, in the projector's frame.
struct Looked {
  Vec3 centre = Vec3::Zero(), into_wall = Vec3::Zero(), down = Vec3::Zero();
  Points3 outline;  ///< what must be in the picture
};

Looked look_at(const PlacedPlane& placed) {
  const auto at = [](const PlacedPlane& plane, double u, double v) {
    const Vec2 point = (plane.plane_from_content * Vec3(u, v, 1)).hnormalized();
    return plane.projector_from_surface * Vec3(point.x(), point.y(), 0);
  };
  Looked looked;
  looked.centre = at(placed, 0.5, 0.5);
  looked.into_wall = placed.projector_from_surface.rotate(Vec3::UnitZ());
  looked.down = (at(placed, 0.5, 1) - at(placed, 0.5, 0)).normalized();
  for (const double u : {-kSeenRound, 1 + kSeenRound})
    for (const double v : {-kSeenRound, 1 + kSeenRound}) looked.outline.push_back(at(placed, u, v));
  return looked;
}

/// Means over its area.
Looked look_at(const PlacedMesh& placed) {
  const Mesh& mesh = *placed.mesh;
  Looked looked;
  double whole = 0;
  for (const auto& triangle : mesh.triangles) {
    const auto corner = [&](std::size_t i) { return mesh.vertices[std::size_t(triangle[i])]; };
    const auto uv = [&](std::size_t i) { return mesh.uv[std::size_t(triangle[i])]; };
    const Vec3 area = area_vector(mesh, triangle);
    const Vec2 a = uv(1) - uv(0), b = uv(2) - uv(0);
    const double sense = a.x() * b.y() - a.y() * b.x();
    if (sense == 0) continue;  // shows one line of the content
    whole += area.norm();
    looked.centre += area.norm() / 3 * (corner(0) + corner(1) + corner(2));
    looked.into_wall += (sense < 0 ? -1 : 1) * area;
    // The step in space for a step in v: point = corner + (a, b)^-1 (u, v).
    const Vec3 along_v = (a.x() * (corner(2) - corner(0)) - b.x() * (corner(1) - corner(0))) / sense;
    looked.down += area.norm() * along_v.normalized();
  }
  const Pose& pose = placed.projector_from_surface;
  looked.centre = pose * Vec3(looked.centre / std::max(whole, 1e-300));
  looked.into_wall = pose.rotate(looked.into_wall) / std::max(whole, 1e-300);
  looked.down = pose.rotate(looked.down) / std::max(whole, 1e-300);
  for (const Vec3& vertex : mesh.vertices)
    looked.outline.push_back(looked.centre + kMeshRound * (pose * vertex - looked.centre));
  return looked;
}

std::vector<Looked> look_at(const Scene& scene) {
  std::vector<Looked> result;
  for (const SceneItem& item : scene.items) {
    if (const auto* plane = std::get_if<PlacedPlane>(&item.placement)) result.push_back(look_at(*plane));
    if (const auto* mesh = std::get_if<PlacedMesh>(&item.placement)) result.push_back(look_at(*mesh));
  }
  return result;
}

}  // namespace

std::optional<Viewpoint> facing_viewpoint(const Scene& scene, ImageSize size) {
  const std::vector<Looked> items = look_at(scene);
  if (items.empty()) return std::nullopt;
  Vec3 centre = Vec3::Zero(), forward = Vec3::Zero(), down = Vec3::Zero();
  for (const Looked& item : items) {
    centre += item.centre / double(items.size());
    forward += item.into_wall;
    down += item.down;
  }
  if (forward.norm() < 1e-3) forward = items.front().into_wall;  // they face each other
  if (forward.norm() < 1e-3) forward = centre;                   // it faces all ways, as a globe does
  forward.normalize();
  down -= down.dot(forward) * forward;
  if (down.norm() < 1e-3) down = forward.unitOrthogonal();
  down.normalize();
  Mat3 camera_from_projector_rotation;
  camera_from_projector_rotation << down.cross(forward).transpose(), down.transpose(), forward.transpose();

  Viewpoint viewpoint;
  viewpoint.camera.size = size;
  Intrinsics& k = viewpoint.camera.intrinsics;
  k.fx = k.fy = 1.2 * size.width;
  k.cx = 0.5 * (size.width - 1);
  k.cy = 0.5 * (size.height - 1);
  double distance = 0.1;
  for (const Looked& item : items)
    for (const Vec3& point : item.outline) {
      const Vec3 corner = camera_from_projector_rotation * (point - centre);
      distance = std::max({distance, k.fx * std::abs(corner.x()) / (0.5 * size.width) - corner.z(),
                           k.fy * std::abs(corner.y()) / (0.5 * size.height) - corner.z()});
    }
  viewpoint.camera_from_projector =
      Pose(camera_from_projector_rotation, Vec3(0, 0, distance) - camera_from_projector_rotation * centre);
  return viewpoint;
}

Scene seen_from(const Pose& other_from_projector, const Scene& scene) {
  Scene seen;
  std::copy_n(scene.background, 3, seen.background);
  for (SceneItem item : scene.items) {
    const bool in_room = std::visit(
        [&](auto& placed) {
          if constexpr (std::is_same_v<std::decay_t<decltype(placed)>, PlacedPixels>) {
            return false;
          } else {
            placed.projector_from_surface = other_from_projector * placed.projector_from_surface;
            return true;
          }
        },
        item.placement);
    if (in_room) seen.items.push_back(std::move(item));
  }
  return seen;
}

}  // namespace procam::render
