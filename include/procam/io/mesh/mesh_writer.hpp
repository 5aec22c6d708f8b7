#pragma once
/// Meshes and point clouds -> files for other programs, and for mesh surfaces (io/surface_file.hpp).
///
///   .ply  Stanford PLY, binary, little-endian: x y z, then s t of meshes, or nx ny nz and sigma of clouds as far as there are
///   .obj  Wavefront OBJ, text; meshes alone
///   .pcd  PCL's point cloud, binary: x y z, then normal_x normal_y normal_z and sigma as far as there are; clouds alone
///
/// Metres, in the frame of the points. Texture coordinates count from the picture's bottom left: (s, t) = (u, 1 - v).
#include <filesystem>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/mesh.hpp"
#include "procam/core/geometry/point_cloud.hpp"

namespace procam::io {

/// Written at once or not at all. Throws Error(kUnsupported) for another extension, Error(kIo), std::invalid_argument for a
/// mesh that cannot be (fault_of) and for a cloud whose lists have different lengths.
PROCAM_EXPORT void save_mesh(const std::filesystem::path& path, const Mesh& mesh);
PROCAM_EXPORT void save_points(const std::filesystem::path& path, const PointCloud& cloud);

}  // namespace procam::io
