#pragma once
/// Warp maps and warp meshes in the files that other programs draw through. Docs: docs/exchange.md.
///
/// | name ends in | what | numbers of a pixel |
/// | .pfm | float map | u, v, 1 where the content is shown (else 0 0 0); v runs down the content |
/// | .png, .exr | ST map, 16-bit / float | red s = u, green t = 1 - v (t runs up), blue 1 where shown |
/// | .obj | mesh | v: the picture as the square 0..1, y up; vt: s = u, t = 1 - v |
///
/// A .png is right to 1/131070 of the content, which is 0.03 pixels of a 4K picture; the others to the 24
/// bits of a float, an .obj to the last bit.
#include <filesystem>

#include "procam/core/base/export.hpp"
#include "procam/core/surface/warp_map.hpp"

namespace procam::io {

/// By the name's extension; Error(kUnsupported) for another than the three, Error(kIo) when it cannot be
/// written. At once or not at all.
PROCAM_EXPORT void save_warp_map(const std::filesystem::path& path, const WarpMap& map);

/// .pfm and .png. Throws Error(kInput) for a file that is damaged, cut short, not a map of three channels, or
/// that has coordinates outside 0..1 or not finite where it shows content; Error(kUnsupported) for another
/// extension or a .png without 16 bits.
PROCAM_EXPORT WarpMap load_warp_map(const std::filesystem::path& path);

/// .obj, else Error(kUnsupported).
PROCAM_EXPORT void save_warp_mesh(const std::filesystem::path& path, const WarpMesh& mesh);

/// `projector`: the size of the picture that the file's square stands for. Polygons are cut into triangles.
/// Errors as for mesh files: kIo for a file that cannot be read, kInput with file and line for one that is no mesh.
PROCAM_EXPORT WarpMesh load_warp_mesh(const std::filesystem::path& path, ImageSize projector);

}  // namespace procam::io
