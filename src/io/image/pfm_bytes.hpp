#pragma once
/// Reading PFM, and PFM in memory.
#include "procam/io/image/pfm.hpp"

namespace procam::io {

/// Reads both byte orders; NaN and infinity are kept. Throws Error(kIo) when the file cannot be read,
/// Error(kInput) when its header is not one, or claims another number of bytes than the file holds: a header
/// never makes memory grow beyond the file's own size.
ImageF load_pfm(const std::filesystem::path& path);

/// The same from memory; `file` is how errors call it.
ImageF decode_pfm(std::string_view bytes, const std::string& file);

std::string encode_pfm(ViewF image);

}  // namespace procam::io
