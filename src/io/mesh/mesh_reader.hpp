#pragma once
/// What the mesh formats share: both parse a whole file in memory.
#include <string_view>

#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/core/geometry/mesh.hpp"

namespace procam::io {

/// `where`: file and line, or file and element.
[[noreturn]] inline void refuse_mesh(
    const std::string& where, const std::string& why,
    const std::string& next = "export the mesh again, as triangles with texture coordinates") {
  throw Error(ErrorKind::kInput, where, why, next);
}

/// A polygon as a fan of triangles about its first corner.
inline void add_fan(const std::vector<int>& corners, const std::string& where, Mesh& mesh) {
  for (std::size_t i = 2; i < corners.size(); ++i)
    mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
  if (mesh.triangles.size() > limits::kMeshTriangles)
    throw Error(ErrorKind::kUnsupported, where, "it has more than 2^24 triangles", "reduce the mesh");
}

/// `name` is the file, for messages.
Mesh parse_obj(std::string_view text, const std::string& name);
Mesh parse_ply(std::string_view bytes, const std::string& name);

}  // namespace procam::io
