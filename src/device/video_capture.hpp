#pragma once
/// OpenCV's way to cameras and videos, quietly.
#include <opencv2/videoio.hpp>
#include <string>

#include "procam/core/base/image.hpp"

namespace procam::device::internal {

/// A device number ("0"), a device, a URL or a file; not open when OpenCV cannot.
cv::VideoCapture open_capture(const std::string& name);

/// OpenCV's grey or BGR picture of 8 bits as grey or RGB, into memory that is used again where it has the
/// right size; false for any other kind of pixels.
bool to_content(const cv::Mat& picture, ImageU8& content);

}  // namespace procam::device::internal
