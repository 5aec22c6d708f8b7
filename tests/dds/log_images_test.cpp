// Images from logs of ROS 2.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "graph_values.hpp"
#include "log_files.hpp"
#include "procam/dds/image_source.hpp"
#include "procam/dds/pose_source.hpp"
#include "procam/io/image/images.hpp"
#include "support/expect_error.hpp"

namespace procam::dds {
namespace {

using test::Cdr;
using test::image_bytes;
using test::kLogStart;
using test::log_folder;
using test::McapFile;
using test::text_of;
using test::write_file;

constexpr std::uint64_t kMs = 1'000'000;
const char* const kRawImage = "sensor_msgs/msg/Image";

/// Four images in 300 ms, of 20, 21, ... grey.
McapFile grey_images() {
  McapFile file;
  file.channel(1, "/eye/image_raw", kRawImage);
  for (int k = 0; k < 4; ++k)
    file.message(1, kLogStart + std::uint64_t(k) * 100 * kMs,
                 text_of(image_bytes(1700000000, unsigned(k) * 100000000, 6, 3, "mono8", 6, 20 + k)));
  return file;
}

std::string stored(const std::string& bytes) {
  const std::string path = (log_folder() / "run.mcap").string();
  write_file(path, bytes);
  return path;
}

TEST(LogImages, ArePlayedInTheirTimeOnceThrough) {
  const std::string path = stored(grey_images().chunk("").closed());
  const double begin = steady_now();
  ImageSource source("log:" + path + "+/eye/image_raw");
  EXPECT_NE(source.description().find("images of /eye/image_raw"), std::string::npos);
  for (int k = 0; k < 4; ++k) {
    const auto image = source.next(5);
    ASSERT_TRUE(image);
    EXPECT_EQ(image->pixels.size(), (ImageSize{6, 3}));
    EXPECT_EQ(image->pixels.at(5, 2), 20 + k);
    EXPECT_NEAR(image->stamp, 1.7e9 + 0.1 * k, 1e-6);
    EXPECT_NEAR(image->time, begin + 0.1 * k, 0.09);
    EXPECT_GE(steady_now(), begin + 0.1 * k);
  }
  EXPECT_FALSE(source.next(0.01));
  EXPECT_FALSE(source.has_publisher());
  EXPECT_EQ(source.last_error(), "the log has ended");
}

/// It is not fetched before it is due, and nothing is lost by asking too early.
TEST(LogImages, AnImageThatIsNotDueIsWaitedFor) {
  const std::string path = stored(grey_images().closed());
  ImageSource source("log:" + path);
  ASSERT_TRUE(source.next(1));
  EXPECT_FALSE(source.next(0.01));
  const auto second = source.next(5);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->pixels.at(0, 0), 21);
}

/// Ten times as fast, together with the poses of the same log.
TEST(LogImages, PlayTogetherWithThePosesOfTheLog) {
  McapFile file = grey_images();
  file.channel(2, "/vicon", "geometry_msgs/msg/PoseStamped");
  Cdr pose;
  test::put(test::put(pose, 1700000000, 0, "map"), test::some_pose(1));
  file.message(2, kLogStart + 2000 * kMs, text_of(pose.bytes()));
  const std::string path = stored(file.closed());
  ImageSource images("log:" + path + "@10");
  const auto poses = open_pose_source("log:" + path + "+/vicon@10");
  const auto image = images.next(1);
  ASSERT_TRUE(image);
  const auto arrived = test::next_poses(*poses);
  ASSERT_EQ(arrived.size(), 1u);
  EXPECT_NEAR(arrived[0].arrival - image->time, 0.2, 1e-3);
}

TEST(LogImages, WhoComesLateGetsTheNewestOne) {
  const std::string path = stored(grey_images().closed());
  // Both at the log's beginning; the second one is fetched when all images are long due.
  ImageSource first("log:" + path), late("log:" + path);
  ASSERT_TRUE(first.next(1));
  std::this_thread::sleep_for(std::chrono::milliseconds(900));
  const auto image = late.next(0.1);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->pixels.at(0, 0), 23);
  EXPECT_FALSE(late.next(0.01));
}

TEST(LogImages, CompressedOnesAndWrongOnes) {
  ImageU8 picture(7, 5, 3);
  for (int i = 0; i < 7 * 5 * 3; ++i) picture.data()[i] = std::uint8_t(7 * i);
  const std::filesystem::path png = log_folder() / "picture.png";
  io::save_image(png, picture.view());
  std::stringstream bytes;
  bytes << std::ifstream(png, std::ios::binary).rdbuf();
  Cdr cdr;
  test::put(cdr, 5, 0, "camera").text("png").number(std::uint32_t(bytes.str().size()));
  for (const char letter : bytes.str()) cdr.number(std::uint8_t(letter));
  const std::string message = text_of(cdr.bytes());
  McapFile file;
  file.channel(1, "/c", "sensor_msgs/msg/CompressedImage");
  file.message(1, kLogStart, message.substr(0, 40)).message(1, kLogStart, message);
  ImageSource source("log:" + stored(file.closed()) + "+/c");
  const auto image = source.next(2);
  ASSERT_TRUE(image);
  EXPECT_TRUE(std::equal(picture.data(), picture.data() + 7 * 5 * 3, image->pixels.data()));
  EXPECT_EQ(source.rejected(), (std::map<std::string, std::uint64_t>{{"ros2_undecodable", 1}}));
}

TEST(LogImages, DepthHasTheLensOfItsCameraInfo) {
  McapFile file;
  file.channel(1, "/depth/image", kRawImage).channel(2, "/depth/camera_info", "sensor_msgs/msg/CameraInfo");
  file.message(2, kLogStart, text_of(test::camera_info_bytes(1700000000, 0, "camera")));
  file.message(1, kLogStart + kMs, text_of(image_bytes(1700000000, 0, 1280, 800, "16UC1", 2560, 3)));
  DepthImageSource source("log:" + stored(file.chunk("").closed()) + "+/depth/image");
  const auto depth = source.next(2);
  ASSERT_TRUE(depth);
  EXPECT_EQ(std::get<Image<std::uint16_t>>(depth->pixels).at(7, 3), 3 * 257);
  EXPECT_EQ(*depth->metres_per_unit, 1e-3);
  ASSERT_TRUE(depth->camera);
  EXPECT_EQ(depth->camera->intrinsics.cy, test::lens_shifted_projector().intrinsics.cy);
}

TEST(LogImages, ALogWithoutSuchImagesTellsWhatItHolds) {
  const std::string path = stored(grey_images().channel(3, "/other", kRawImage).closed());
  EXPECT_ERROR(ImageSource("log:" + path), kInput, "it holds /eye/image_raw (sensor_msgs/msg/Image), /other");
  EXPECT_ERROR(ImageSource("log:" + path + "+/nothing"), kInput, "no images of the topic /nothing");
  EXPECT_ERROR(ImageSource("log:" + path + "+/other@0"), kInput, "all at once");
  EXPECT_ERROR(ImageSource("log:" + path + ".no"), kIo, "there is no such file");
}

}  // namespace
}  // namespace procam::dds
