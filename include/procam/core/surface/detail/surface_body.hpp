#pragma once
/// The bodies of surface.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>

#include "procam/core/base/error.hpp"
#include "procam/core/surface/surface.hpp"

namespace procam {

PROCAM_CORE_INLINE std::shared_ptr<const Mesh> mesh_of(const Surface& surface) {
  const auto refuse = [&](const std::string& why) {
    throw Error(ErrorKind::kInput, "surface '" + surface.name + "'", why, "correct its definition");
  };
  return std::visit(
      [&](const auto& shape) -> std::shared_ptr<const Mesh> {
        using Shape = std::decay_t<decltype(shape)>;
        if constexpr (std::is_same_v<Shape, PlanarSurface> || std::is_same_v<Shape, PixelSurface>) {
          return nullptr;
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
