#pragma once
/// PFM, the portable float map: pictures of 32-bit floats, 1 or 3 channels.
///
/// A header of text, "PF" (3 channels) or "Pf" (1), width, height and scale, then the rows from the bottom
/// upwards. A negative scale says that the bytes of a number come lowest first; its size is not applied. In
/// memory the top row comes first, as everywhere in procam. (P. Debevec's HDR Shop; the warps of MPCDI.)
#include <filesystem>
#include <string>
#include <string_view>

#include "procam/core/base/image.hpp"

namespace procam::io {

/// Reads both byte orders; NaN and infinity are kept. Throws Error(kIo) when the file cannot be read,
/// Error(kInput) when its header is not one, or claims another number of bytes than the file holds: a header
/// never makes memory grow beyond the file's own size.
ImageF load_pfm(const std::filesystem::path& path);
/// The same from memory; `file` is how errors call it.
ImageF decode_pfm(std::string_view bytes, const std::string& file);

/// Written lowest byte first, at once or not at all. 1 or 3 channels, else std::invalid_argument.
void save_pfm(const std::filesystem::path& path, ViewF image);
std::string encode_pfm(ViewF image);

}  // namespace procam::io
