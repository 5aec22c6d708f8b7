#pragma once
/// Triangles in space with content coordinates: what every surface that is not plane is drawn as.
///
/// Within a triangle the content coordinates are linear in the place on it (uv = sum b_i uv_i with the
/// barycentric coordinates b_i). Either sense of the corners: both sides of a triangle are seen.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <optional>
#include <string>

#include "procam/core/base/types.hpp"

namespace procam {

struct Mesh {
  Points3 vertices;  ///< metres, in the mesh's own frame
  Points2 uv;        ///< content coordinates (core/surface/surface.hpp), one a vertex
  std::vector<std::array<int, 3>> triangles;  ///< vertices, by their places in the list
};

/// Twice the area's vector of a triangle, along its normal.
inline Vec3 area_vector(const Mesh& mesh, const std::array<int, 3>& triangle) {
  const Vec3& a = mesh.vertices[std::size_t(triangle[0])];
  return (mesh.vertices[std::size_t(triangle[1])] - a).cross(mesh.vertices[std::size_t(triangle[2])] - a);
}

/// Why nothing can be drawn on it, in words; nullopt for a good mesh: at least one triangle, a uv for every
/// vertex, numbers all finite, corners that exist, and no triangle without area (less than 1e-12 of its
/// longest side squared).
inline std::optional<std::string> fault_of(const Mesh& mesh) {
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
