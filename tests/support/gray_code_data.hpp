#pragma once
/// The real captures graycode/capture_N of the test data, read with OpenCV as referee's eyes.
#include <cstdio>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "procam/core/base/image.hpp"
#include "support/test_data.hpp"

namespace procam::test {

/// 42 grey frames, or none where the data are absent.
inline std::vector<cv::Mat> real_gray_code(int pose) {
  std::vector<cv::Mat> frames;
  if (!std::filesystem::exists(test_data() / "graycode")) return frames;
  for (int i = 0; i < 42; ++i) {
    char name[64];
    std::snprintf(name, sizeof name, "graycode/capture_%d/graycode_%02d.png", pose, i);
    frames.push_back(cv::imread((test_data() / name).string(), cv::IMREAD_GRAYSCALE));
  }
  return frames;
}

inline std::vector<ViewU8> views_of(const std::vector<cv::Mat>& frames) {
  std::vector<ViewU8> views;
  for (const cv::Mat& frame : frames)
    views.emplace_back(frame.data, frame.cols, frame.rows, 1, std::ptrdiff_t(frame.step1()));
  return views;
}

}  // namespace procam::test
