#pragma once
/// Mesh files -> Mesh: Wavefront OBJ (.obj) and Stanford PLY (.ply; text, little- and big-endian binary).
///
/// Only what a surface needs is read: positions, texture coordinates, faces (polygons are cut into fans).
/// Texture coordinates count from the picture's bottom left in these formats: (u, v) = (s, 1 - t). An OBJ
/// corner is a pair of position and texture coordinate, each used pair one vertex here. A PLY carries them a
/// vertex, as s, t (also u, v or texture_u, texture_v). Numbers stay in the file's unit.
///
/// Throws Error with file and line (or element): kInput for what is no such file, ends early, has numbers
/// that are not finite, corners that do not exist, no texture coordinates, a triangle without area, or claims
/// more than it holds; kUnsupported for another extension or more than 2^24 triangles; kIo when it cannot be
/// read. Memory stays within a small multiple of the file's size, whatever its header claims.
#include <filesystem>

#include "procam/core/geometry/mesh.hpp"

namespace procam::io {

Mesh load_mesh(const std::filesystem::path& path);

}  // namespace procam::io
