#include "video_capture.hpp"

#include <algorithm>
#include <filesystem>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/videoio/registry.hpp>

namespace procam::device::internal {

/// Files and addresses, by FFmpeg where OpenCV has it. The other backends leave memory behind for each file that they
/// cannot open, and a broken file is tried every second. An address that does not answer, or stops sending, is given up
/// after some seconds (OpenCV's own limit is 30 s), because a thread that waits for it cannot be ended before.
static void open_stream(cv::VideoCapture& video, const std::string& name) {
  const auto backends = cv::videoio_registry::getStreamBackends();
  if (std::find(backends.begin(), backends.end(), cv::CAP_FFMPEG) == backends.end())
    video.open(name);
  else
    video.open(name, cv::CAP_FFMPEG,
               {cv::CAP_PROP_OPEN_TIMEOUT_MSEC, 5000, cv::CAP_PROP_READ_TIMEOUT_MSEC, 5000});
}

cv::VideoCapture open_capture(const std::string& name) {
  const bool is_number =
      !name.empty() && name.size() < 5 &&
      std::all_of(name.begin(), name.end(), [](unsigned char c) { return c >= '0' && c <= '9'; });
  // OpenCV tells of every driver that it tries; what matters of that is in the caller's error.
  const auto level = cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  cv::VideoCapture video;
  std::error_code ignored;
  try {
    if (is_number)
      video.open(std::stoi(name));
    else if (name.find("://") != std::string::npos || std::filesystem::is_regular_file(name, ignored))
      open_stream(video, name);
    else  // a device by its name
      video.open(name);
  } catch (const cv::Exception&) {
    video.release();
  }
  cv::utils::logging::setLogLevel(level);
  return video;
}

bool to_content(const cv::Mat& picture, ImageU8& content) {
  const int channels = picture.channels();
  if (picture.empty() || picture.depth() != CV_8U || (channels != 1 && channels != 3)) return false;
  if (content.width() != picture.cols || content.height() != picture.rows || content.channels() != channels)
    content = ImageU8(picture.cols, picture.rows, channels);
  for (int y = 0; y < picture.rows; ++y) {
    const std::uint8_t* from = picture.ptr<std::uint8_t>(y);
    std::uint8_t* to = content.row(y);
    if (channels == 1) {
      std::copy_n(from, picture.cols, to);
      continue;
    }
    for (int x = 0; x < picture.cols; ++x, from += 3, to += 3) {
      to[0] = from[2];
      to[1] = from[1];
      to[2] = from[0];
    }
  }
  return true;
}

}  // namespace procam::device::internal
