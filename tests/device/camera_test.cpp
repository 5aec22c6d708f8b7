/// OpenCV's cameras, on a video that is written here: no hardware is needed to read one.
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "procam/device/frame_source.hpp"

namespace procam::device {
namespace {

TEST(Camera, ReadsGreyFramesUntilTheVideoEnds) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("procam_video_" + std::to_string(getpid()) + ".avi");
  constexpr int kFrames = 6;
  {
    cv::VideoWriter video(file.string(), cv::CAP_OPENCV_MJPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'),
                          20, {64, 48});
    ASSERT_TRUE(video.isOpened());
    for (int i = 0; i < kFrames; ++i) video.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(30 * i)));
  }
  const auto camera = open_camera(file.string());
  double last = 0;
  for (int i = 0; i < kFrames; ++i) {
    const auto frame = camera->next(last, 5);
    ASSERT_TRUE(frame) << i;
    EXPECT_EQ(frame->image.size(), (ImageSize{64, 48}));
    EXPECT_EQ(frame->image.channels(), 1);
    EXPECT_NEAR(frame->image.at(10, 10), 30 * i, 4);
    EXPECT_GT(frame->time_s, last);
    last = frame->time_s;
  }
  try {
    camera->next(last, 5);
    FAIL() << "more frames than were written";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kDevice);
  }
  std::filesystem::remove(file);
}

TEST(Camera, ThatIsNotThereIsADeviceError) {
  for (const char* name : {"97", "/nowhere/video.avi"}) {
    try {
      open_camera(name);
      FAIL() << name;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kDevice);
      EXPECT_NE(error.subject().find(name), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace procam::device
