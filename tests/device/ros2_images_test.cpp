// Topics of the ROS 2 graph as cameras, contents and depth cameras: real DDS traffic on the loopback interface.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <thread>

#include "dds/graph_values.hpp"
#include "dds/image_messages.hpp"
#include "dds/log_files.hpp"
#include "dds/ros2_peer.hpp"
#include "procam/device/content_source.hpp"
#include "procam/device/depth_source.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/device/frame_source.hpp"
#include "support/expect_error.hpp"

namespace procam::device {
namespace {

using test::grey_image;
using test::ImageMessage;
using test::LoopbackDomain;
using test::Ros2Peer;
using test::write_image;

/// Publishes what `next` gives, every 20 ms, until it is destroyed.
class Publisher {
 public:
  Publisher(dds_entity_t writer, std::function<ImageMessage(int)> next) {
    thread_ = std::thread([this, writer, next = std::move(next)] {
      for (int i = 0; !ends_; ++i) {
        write_image(writer, next(i));
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
      }
    });
  }
  ~Publisher() {
    ends_ = true;
    thread_.join();
  }

 private:
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

/// One colour image of 6 x 3 pixels.
ImageMessage colour(int i) {
  ImageMessage message;
  message.stamp = 100 + 0.02 * i;
  message.width = 6;
  message.height = 3;
  message.encoding = "rgb8";
  message.step = 18;
  for (int k = 0; k < 18; ++k) {
    message.data.push_back(200);
    message.data.push_back(100);
    message.data.push_back(50);
  }
  return message;
}

TEST(Ros2Camera, GivesGreyFramesInOrderWhereverACameraIsNamed) {
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  const auto camera = open_camera("ros2:/camera/image_raw");  // before there is a publisher
  const Publisher publisher(robot.writer(sensor_msgs_msg_dds__Image__desc, "rt/camera/image_raw", false),
                            colour);
  double last = 0;
  for (int i = 0; i < 5; ++i) {
    const auto frame = camera->next(last, 8);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->image.channels(), 1);
    EXPECT_EQ(frame->image.size(), (ImageSize{6, 3}));
    EXPECT_EQ(frame->image.at(4, 2), 100);  // the green of (200, 100, 50)
    EXPECT_GT(frame->time_s, last);
    EXPECT_NEAR(frame->time_s, now_s(), 5);
    last = frame->time_s;
  }
  CameraOptions options;
  options.size = ImageSize{8, 3};
  const auto of_size = open_camera("ros2:/camera/image_raw", options);
  EXPECT_ERROR(of_size->next(0, 8), kInput, "6x3 pixels, not 8x3");
  options.size = ImageSize{6, 3};
  EXPECT_TRUE(open_camera("ros2:/camera/image_raw", options)->next(0, 8));
  options.exposure = 3;
  EXPECT_ERROR(open_camera("ros2:/camera/image_raw", options), kInput, "exposure");
  EXPECT_ERROR(open_camera("ros2:camera,b"), kInput, "one topic");
  EXPECT_ERROR(open_camera("ros2:"), kInput, "nothing follows");
}

TEST(Ros2Camera, OneThatDoesNotPublishIsADeviceErrorWithTheReason) {
  const LoopbackDomain domain;
  const auto camera = open_camera("ros2:/nothing");
  EXPECT_FALSE(camera->next(0, 0.2));
  EXPECT_ERROR(camera->next(0, 10), kDevice,
               "no publisher of /nothing was found in ROS domain " + std::to_string(domain.number()));
  const Ros2Peer robot(domain);
  const auto wrong = open_camera("ros2:/wrong");
  const Publisher publisher(robot.writer(sensor_msgs_msg_dds__Image__desc, "rt/wrong"), [](int i) {
    ImageMessage message = grey_image(i, 1);
    message.encoding = "32FC1";
    return message;
  });
  EXPECT_ERROR(wrong->next(0, 10), kDevice, "encoding '32FC1' is not read here");
  EXPECT_GT(wrong->rejected()["ros2_unknown_encoding"], 0u);
}

TEST(Ros2Content, IsTheNewestImageAndSaysWhyNoneCome) {
  const LoopbackDomain domain;
  ContentOptions options;
  options.camera_patience_s = 0.3;
  EXPECT_ERROR(open_content("ros2:/image", options), kDevice, "no publisher of /image was found");
  options.camera_patience_s = 10;
  const Ros2Peer robot(domain);
  const dds_entity_t writer = robot.writer(sensor_msgs_msg_dds__Image__desc, "rt/image");
  std::atomic<int> what{0};
  const Publisher publisher(writer, [&](int i) {
    ImageMessage message = colour(i);
    if (what == 1) message.data.assign(54, 7);
    if (what == 2) message = grey_image(i, 200);
    if (what == 3) message.step = 4;
    return message;
  });
  const auto content = open_content("ros2:/image", options);
  EXPECT_FALSE(content_file("ros2:/image"));
  EXPECT_EQ(content_beside("/folder/surfaces.json", "ros2:/image"), "ros2:/image");
  ContentFrame frame = content->at(0);
  EXPECT_EQ(frame.view.channels, 3);
  EXPECT_EQ(frame.view.at(5, 2, 0), 200);
  EXPECT_EQ(frame.view.at(5, 2, 2), 50);
  const auto wait_for = [&](auto holds) {
    const double deadline = now_s() + 10;
    while (!holds() && now_s() < deadline) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return holds();
  };
  const std::uint64_t revision = frame.revision;
  what = 1;
  EXPECT_TRUE(wait_for([&] { return content->at(0).view.at(0, 0, 1) == 7; }));
  EXPECT_GT(content->at(0).revision, revision);
  EXPECT_FALSE(content->fault());
  what = 2;  // of another size and number of channels
  EXPECT_TRUE(wait_for([&] { return content->fault().has_value(); }));
  EXPECT_TRUE(test::contains(content->fault()->what(), "have become 12x7 with 1 channels"));
  EXPECT_EQ(content->at(0).view.width, 6);
  what = 0;
  EXPECT_TRUE(wait_for([&] { return !content->fault() && content->at(0).view.at(0, 0, 1) == 100; }));
  what = 3;
  EXPECT_TRUE(wait_for([&] { return content->rejected()["ros2_invalid_image"] > 0; }));
}

TEST(Ros2Depth, IsADepthSourceWithUnitLensAndStamp) {
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  const auto source = open_depth("ros2:/camera/depth/image_raw");
  const Publisher publisher(
      robot.writer(sensor_msgs_msg_dds__Image__desc, "rt/camera/depth/image_raw", false), [](int i) {
        ImageMessage message = grey_image(50 + 0.02 * i, 4, 6, 3);
        message.encoding = "16UC1";
        message.width = 3;
        return message;
      });
  const dds_entity_t infos =
      robot.writer(sensor_msgs_msg_dds__CameraInfo__desc, "rt/camera/depth/camera_info", true, true);
  test::write_camera_info(infos, 3, 3, 2.5, 0.25, {0.1, 0, 0, 0, 0});
  double after = 0;
  for (const double deadline = now_s() + 10; now_s() < deadline;) {
    const auto seen = source->next(after, 8);
    ASSERT_TRUE(seen);
    EXPECT_EQ(std::get<Image<std::uint16_t>>(seen->pixels).at(2, 2), 0x0404);
    EXPECT_EQ(seen->metres_per_unit, 1e-3);
    EXPECT_GT(seen->time_s, after);
    ASSERT_TRUE(seen->stamp_s);
    after = seen->time_s;
    if (!seen->camera) continue;
    EXPECT_EQ(seen->camera->intrinsics.skew, 0.25);
    return;
  }
  FAIL() << "no lens came";
}

/// The three kinds of sources, of a log.
TEST(Ros2Log, IsACameraAContentAndADepthCamera) {
  test::McapFile file;
  constexpr std::uint64_t kStart = 1'700'000'000'000'000'000;
  file.channel(1, "/eye", "sensor_msgs/msg/Image").channel(2, "/depth", "sensor_msgs/msg/Image");
  for (int k = 0; k < 3; ++k) {
    const std::uint64_t time = kStart + std::uint64_t(k) * 200'000'000;
    const unsigned nanosec = unsigned(k) * 200'000'000;
    file.message(1, time, test::text_of(test::image_bytes(1700000000, nanosec, 6, 3, "rgb8", 18, 40 + k)));
    file.message(2, time, test::text_of(test::image_bytes(1700000000, nanosec, 4, 3, "16UC1", 8, 2)));
  }
  const std::string path = (test::log_folder() / "run.mcap").string();
  test::write_file(path, file.chunk("").closed());
  const auto camera = open_camera("log:" + path + "+/eye");
  const auto depth = open_depth("log:" + path + "+/depth");
  const auto content = open_content("log:" + path + "+/eye");
  const auto seen = camera->next(0, 5);
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->image.size(), (ImageSize{6, 3}));
  EXPECT_EQ(seen->image.channels(), 1);
  const auto measured = depth->next(0, 5);
  ASSERT_TRUE(measured);
  EXPECT_EQ(*measured->metres_per_unit, 1e-3);
  ContentFrame last;
  for (const double begin = now_s();
       now_s() < begin + 5 && (last.view.data == nullptr || last.view.at(0, 0) != 42);)
    last = content->at(now_s() - begin);
  EXPECT_EQ(last.view.at(5, 2, 1), 42) << "contents keep their last image";
  // Beside a surfaces file, as other files are.
  EXPECT_EQ(content_beside("/show/surfaces.json", "log:run.mcap+/eye@2"), "log:/show/run.mcap+/eye@2");
  EXPECT_ERROR(open_camera("log:" + path + "+/none"), kInput, "it holds /eye (sensor_msgs/msg/Image)");
}

}  // namespace
}  // namespace procam::device
