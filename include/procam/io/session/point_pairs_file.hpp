#pragma once
/// points.csv -> points of a room with the pixels that see or light them.
///
///   # the lab, measured from the corner by the door
///   x, y, z, u, v, name
///   0.000, 0.000, 1.204, 312.5, 88.0, shelf left
///   1.35, 0.02, 2.417, 901, 140
///
/// Metres and pixels (the centre of the top-left one is 0, 0), in that order; the name may be absent, and so
/// may the line of column names. Separated by commas, semicolons or tabs; '#' begins a comment.
#include <filesystem>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/rig/observation.hpp"

namespace procam::io {

/// Throws Error(kIo) for a file that cannot be read, Error(kInput) naming file, line and column.
PROCAM_EXPORT std::vector<PointPair> load_point_pairs(const std::filesystem::path& path);

}  // namespace procam::io
