#pragma once
/// The bodies of surface.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include <algorithm>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "procam/core/base/error.hpp"
#include "procam/core/geometry/homography.hpp"
#include "procam/core/surface/surface.hpp"
#include "procam/core/surface/tessellate.hpp"

namespace procam {
namespace detail {

/// A surface in pixels with cells so small that a lens does not bend within one.
template <typename Shape>
struct FineCells {
  const Shape& shape;
  Vec3 point(const Vec2& uv) const { return shape.point(uv); }
  std::array<int, 2> cells() const {
    constexpr int kFewest = 16;
    std::array<int, 2> count = shape.cells();
    for (int& side : count) side *= (kFewest + side - 1) / side;
    return count;
  }
};

/// Null for a flat one. Throws what tessellate() does.
inline std::shared_ptr<const Mesh> mesh_in_pixels(const PixelSurface& surface) {
  if (!surface.is_curved()) return nullptr;
  const auto drawn = [](const auto& shape) {
    using Shape = std::decay_t<decltype(shape)>;
    return std::make_shared<const Mesh>(tessellate(FineCells<Shape>{shape}, kPixelTolerance));
  };
  return surface.shape == PixelShape::kGrid ? drawn(surface.as_grid()) : drawn(surface.as_bezier());
}

}  // namespace detail

PROCAM_CORE_INLINE PlacedMesh mesh_on_rays(const PlacedPixels& placed, const Projector& projector) {
  require(placed.mesh != nullptr, "mesh_on_rays: the surface is flat");
  constexpr double kSideways = 0.1;  // z of a unit direction, below which its length is kept
  Mesh lit;
  lit.uv = placed.mesh->uv;
  std::vector<bool> is_lit;
  for (const Vec3& vertex : placed.mesh->vertices) {
    const std::optional<Ray> ray = projector.emit(vertex.head<2>());
    is_lit.push_back(ray.has_value());
    const Vec3 direction = ray ? ray->direction : Vec3(Vec3::UnitZ());
    lit.vertices.push_back(direction.z() > kSideways ? Vec3(direction / direction.z()) : direction);
  }
  for (const std::array<int, 3>& triangle : placed.mesh->triangles)
    if (std::all_of(triangle.begin(), triangle.end(), [&](int i) { return is_lit[std::size_t(i)]; }))
      lit.triangles.push_back(triangle);
  return {std::make_shared<const Mesh>(std::move(lit)), Pose::identity()};
}

PROCAM_CORE_INLINE std::optional<Vec2> pixel_at(const PlacedPixels& placed, const Vec2& uv) {
  if (!placed.mesh) return Homography(placed.pixel_from_content).apply(uv);
  constexpr double kRounding = 1e-9;
  const Mesh& mesh = *placed.mesh;
  for (const std::array<int, 3>& triangle : mesh.triangles) {
    const auto corner = [&](std::size_t i) { return std::size_t(triangle[i]); };
    const Vec2 &a = mesh.uv[corner(0)], p = mesh.uv[corner(1)] - a, q = mesh.uv[corner(2)] - a, d = uv - a;
    const double area = p.x() * q.y() - p.y() * q.x();
    const double s = (d.x() * q.y() - d.y() * q.x()) / area, t = (p.x() * d.y() - p.y() * d.x()) / area;
    if (!(s >= -kRounding && t >= -kRounding && s + t <= 1 + kRounding)) continue;
    return Vec2(
        ((1 - s - t) * mesh.vertices[corner(0)] + s * mesh.vertices[corner(1)] + t * mesh.vertices[corner(2)])
            .head<2>());
  }
  return std::nullopt;
}

PROCAM_CORE_INLINE std::shared_ptr<const Mesh> mesh_of(const Surface& surface) {
  const auto refuse = [&](const std::string& why) {
    throw Error(ErrorKind::kInput, "surface '" + surface.name + "'", why, "correct its definition");
  };
  return std::visit(
      [&](const auto& shape) -> std::shared_ptr<const Mesh> {
        using Shape = std::decay_t<decltype(shape)>;
        if constexpr (std::is_same_v<Shape, PlanarSurface>) {
          return nullptr;
        } else if constexpr (std::is_same_v<Shape, PixelSurface>) {
          if (const char* fault = shape.fault()) refuse(fault);
          std::shared_ptr<const Mesh> mesh;
          try {
            mesh = detail::mesh_in_pixels(shape);
          } catch (const Error&) {
            refuse("its points are so far apart that 1024 triangles a side do not follow it");
          }
          if (mesh)
            if (const auto fault = fault_of(*mesh)) refuse(*fault);
          return mesh;
        } else {
          if (const char* fault = shape.fault()) refuse(fault);
          std::shared_ptr<const Mesh> mesh;
          if constexpr (std::is_same_v<Shape, MeshSurface>)
            mesh = shape.mesh;
          else
            mesh = std::make_shared<const Mesh>(tessellate(shape, kTessellationTolerance));
          if (const auto fault = fault_of(*mesh)) refuse(*fault);
          return mesh;
        }
      },
      surface.geometry);
}

PROCAM_CORE_INLINE const InRoom* place_of(const SurfaceGeometry& geometry) {
  return std::visit(
      [](const auto& shape) -> const InRoom* {
        if constexpr (std::is_base_of_v<InRoom, std::decay_t<decltype(shape)>>)
          return &shape;
        else
          return nullptr;
      },
      geometry);
}

PROCAM_CORE_INLINE InRoom* place_of(SurfaceGeometry& geometry) {
  return const_cast<InRoom*>(place_of(std::as_const(geometry)));
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
