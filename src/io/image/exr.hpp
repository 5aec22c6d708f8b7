#pragma once
/// OpenEXR pictures of floats, written without compression.
#include <string>

#include "procam/core/base/image.hpp"

namespace procam::io {

/// Three channels, R G B. (OpenEXR file layout: https://openexr.com/en/latest/OpenEXRFileLayout.html, a
/// single part of scan lines.) procam writes these itself: OpenCV's EXR is off unless an environment variable
/// says otherwise.
std::string encode_exr(ViewF image);

}  // namespace procam::io
