/// OpenCV's cameras, on a video that is written here: no hardware is needed to read one.
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "procam/device/frame_source.hpp"
#include "procam/io/image/images.hpp"
#include "support/expect_error.hpp"

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

/// One function for all that may be named as a camera.
TEST(Camera, IsNamedByItsKindOrWithoutIt) {
  std::string name = (std::filesystem::temp_directory_path() / "procam_camera_XXXXXX").string();
  const std::filesystem::path folder = mkdtemp(name.data());
  for (const std::string& text : {folder.string(), "watch:" + folder.string()}) {
    const auto camera = open_camera(text);
    EXPECT_FALSE(camera->next(0, 0.02));
    io::save_image(folder / "one.png", ImageU8(9, 5, 3, 80));
    const auto frame = camera->next(0, 5);
    ASSERT_TRUE(frame) << text;
    EXPECT_EQ(frame->image.size(), (ImageSize{9, 5}));
    std::filesystem::remove(folder / "one.png");
  }
  CameraOptions options;
  options.size = ImageSize{8, 5};
  const auto of_size = open_camera("watch:" + folder.string(), options);
  io::save_image(folder / "two.png", ImageU8(9, 5, 3, 80));
  EXPECT_ERROR(of_size->next(0, 5), kInput, "9x5 pixels, not 8x5");
  options.exposure = 1;
  EXPECT_ERROR(open_camera(folder.string(), options), kInput, "exposure");
  EXPECT_ERROR(open_camera("watch:" + (folder / "none").string()), kDevice, "none");
  EXPECT_ERROR(open_camera("camera:97"), kDevice, "camera 97");
  EXPECT_ERROR(open_camera("camera:"), kInput, "nothing follows");
  std::filesystem::remove_all(folder);
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
