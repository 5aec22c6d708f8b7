#pragma once
/// A picture's file -> OpenCV's pixels, checked on the way: what images.cpp and warp_file.cpp read through.
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>

namespace procam::io {

/// The picture in these bytes, in its own depth and with OpenCV's order of channels (blue first). Errors as
/// for load_image(); `file` is how they call it.
cv::Mat decode_image(const std::string& bytes, const std::string& file);

}  // namespace procam::io
