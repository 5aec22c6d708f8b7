#pragma once
/// PFM, the portable float map: pictures of 32-bit floats, 1 or 3 channels.
///
/// A header of text, "PF" (3 channels) or "Pf" (1), width, height and scale, then the rows from the bottom
/// upwards. A negative scale says that the bytes of a number come lowest first; its size is not applied. In
/// memory the top row comes first, as everywhere in procam. (P. Debevec's HDR Shop; the warps of MPCDI.)
#include <filesystem>
#include <string>
#include <string_view>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"

namespace procam::io {

/// Written lowest byte first, at once or not at all. 1 or 3 channels, else std::invalid_argument.
PROCAM_EXPORT void save_pfm(const std::filesystem::path& path, ViewF image);

}  // namespace procam::io
