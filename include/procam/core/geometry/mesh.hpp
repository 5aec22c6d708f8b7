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

#include "procam/core/base/export.hpp"
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
PROCAM_EXPORT std::optional<std::string> fault_of(const Mesh& mesh);

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/geometry/detail/mesh_body.hpp"
#endif
