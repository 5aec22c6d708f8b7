#pragma once
/// The bodies of mesh.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include "procam/core/geometry/mesh.hpp"

namespace procam {

PROCAM_CORE_INLINE std::optional<std::string> fault_of(const Mesh& mesh) {
  if (mesh.triangles.empty()) return "it has no triangle";
  if (mesh.uv.size() != mesh.vertices.size())
    return std::to_string(mesh.vertices.size()) + " vertices have " + std::to_string(mesh.uv.size()) +
           " content coordinates (uv)";
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if (!mesh.vertices[i].allFinite() || !mesh.uv[i].allFinite())
      return "vertex " + std::to_string(i) + " has a position or content coordinate that is not finite";
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    double longest = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      const int corner = mesh.triangles[i][j];
      if (corner < 0 || std::size_t(corner) >= mesh.vertices.size())
        return "triangle " + std::to_string(i) + " has a corner " + std::to_string(corner) +
               ", and there are " + std::to_string(mesh.vertices.size()) + " vertices";
    }
    for (std::size_t j = 0; j < 3; ++j)
      longest = std::max(longest, (mesh.vertices[std::size_t(mesh.triangles[i][j])] -
                                   mesh.vertices[std::size_t(mesh.triangles[i][(j + 1) % 3])])
                                      .squaredNorm());
    if (!(area_vector(mesh, mesh.triangles[i]).norm() > 1e-12 * longest))
      return "triangle " + std::to_string(i) + " has no area (its corners lie on one line)";
  }
  return std::nullopt;
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
