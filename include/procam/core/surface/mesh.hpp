#pragma once
/// A surface of any shape, as a scanner or a modelling program gives it.
#include <memory>
#include <optional>

#include "procam/core/geometry/mesh.hpp"
#include "procam/core/surface/in_room.hpp"

namespace procam {

struct MeshSurface : InRoom {
  std::string file;                  ///< .obj or .ply, beside the surfaces file
  double metres_per_unit = 1;        ///< of the file's numbers
  std::shared_ptr<const Mesh> mesh;  ///< as loaded, metres; set by io::load_surfaces

  const char* fault() const { return mesh ? nullptr : "its mesh is not loaded"; }
};

/// A surface of triangles, solved: they are placed, and seen by the full projector model.
struct PlacedMesh {
  std::shared_ptr<const Mesh> mesh;  ///< in the surface's frame
  Pose projector_from_surface;
  /// Content coordinates by a projection instead of the mesh's uv: q = P (x, y, z, 1) for a point in the
  /// surface's frame, (u, v) = q_xy / q_z, exact within a triangle. What a viewer's picture is laid on the
  /// room with (render/viewer.hpp); renderers alone know it.
  std::optional<Mat34> content_from_point = {};
};

}  // namespace procam
