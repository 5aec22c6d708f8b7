#pragma once
/// The same of a picture in memory.
#include <string_view>

#include "procam/io/image/exif.hpp"

namespace procam::io {

std::optional<ExifFocal> exif_focal_in(std::string_view picture);

}  // namespace procam::io
