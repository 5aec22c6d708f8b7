// Images of the ROS 2 graph: real DDS traffic through sockets of the loopback interface, written by a second DDS domain.
#include <gtest/gtest.h>

#include <chrono>
#include <ctime>
#include <thread>

#include "graph_values.hpp"
#include "image_messages.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/dds/image_source.hpp"
#include "procam/dds/pose_source.hpp"
#include "procam/io/image/images.hpp"
#include "ros2_peer.hpp"
#include "support/expect_error.hpp"

namespace procam::dds {
namespace {

using test::grey_image;
using test::ImageMessage;
using test::in_step;
using test::LoopbackDomain;
using test::Ros2Peer;
using test::wait_until;
using test::write_image;

const auto& kImage = sensor_msgs_msg_dds__Image__desc;
const auto& kCompressed = sensor_msgs_msg_dds__CompressedImage__desc;

/// Reads while it waits: discovery is the source's reader's work.
template <typename Source>
bool has_reader(Source& source, dds_entity_t writer) {
  return wait_until([&] {
    source.next(0);
    dds_publication_matched_status_t matched;
    return dds_get_publication_matched_status(writer, &matched) == DDS_RETCODE_OK &&
           matched.current_count >= 1 && source.has_publisher();
  });
}

/// Writes until an image arrives: the writer may know the reader before the reader knows the writer. Its value.
int value_of_next(ImageSource& source, dds_entity_t writer, int value) {
  for (int i = 0; i < 100; ++i) {
    write_image(writer, grey_image(5 + 0.1 * i, value));
    while (const auto image = source.next(0.1))
      if (image->pixels.at(0, 0) == value) return value;
  }
  return -1;
}

TEST(Ros2Images, AnImageArrivesAsItWasSentAndTheReasonIsGivenBefore) {
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  ImageSource source("image,__ns:=/left,/left/image:=/cameras/left/image_raw");
  EXPECT_EQ(source.description(), "ROS 2 domain " + std::to_string(domain.number()) +
                                      ", network lo (127.0.0.1): images of /cameras/left/image_raw");
  EXPECT_FALSE(source.next(0.05));
  EXPECT_FALSE(source.has_publisher());
  EXPECT_TRUE(test::contains(source.last_error(), "no publisher of /cameras/left/image_raw was found"));
  const dds_entity_t writer = robot.writer(kImage, "rt/cameras/left/image_raw");
  ASSERT_TRUE(has_reader(source, writer));
  EXPECT_TRUE(test::contains(source.last_error(), "no image has come"));
  ASSERT_TRUE(in_step(source, [&] { write_image(writer, grey_image(1700000000, 1)); }));
  ImageMessage message;
  message.stamp = 1700000000.25;
  message.width = 5;
  message.height = 3;
  message.encoding = "bgr8";
  message.step = 17;
  for (int i = 0; i < 51; ++i) message.data.push_back(std::uint8_t(5 * i));
  const double sent = steady_now();
  write_image(writer, message);
  const std::optional<ReceivedImage> image = source.next(8);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->stamp, 1700000000.25);
  EXPECT_GE(image->time, sent);
  EXPECT_LE(image->time, steady_now());
  ASSERT_EQ(image->pixels.size(), (ImageSize{5, 3}));
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 5; ++x)
      for (int k = 0; k < 3; ++k)
        EXPECT_EQ(image->pixels.at(x, y, k), std::uint8_t(5 * (17 * y + 3 * x + 2 - k)));
  EXPECT_TRUE(source.rejected().empty());
  dds_delete(writer);
  EXPECT_TRUE(wait_until([&] { return source.next(0.01), !source.has_publisher(); }));
  EXPECT_TRUE(test::contains(source.last_error(), "has gone")) << source.last_error();
  for (const char* text : {"", "/a,/b", "/a b", "/a/", ","}) EXPECT_ERROR(ImageSource{text}, kInput, "ros2:");
}

TEST(Ros2Images, ASourceThatWaitsUsesNoProcessorTime) {
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  ImageSource source("/image");
  const dds_entity_t writer = robot.writer(kImage, "rt/image");
  ASSERT_TRUE(has_reader(source, writer));
  const std::clock_t used = std::clock();
  EXPECT_FALSE(source.next(0.7));
  EXPECT_LT(double(std::clock() - used) / CLOCKS_PER_SEC, 0.15) << "of 0.7 s";
}

TEST(Ros2Images, AReaderIsAsReliableAsItsPublishersAlsoWhenTheyChange) {
  const LoopbackDomain domain;
  ImageSource source("/image");
  const Ros2Peer robot(domain);
  // A reliable driver; it comes back with "sensor data" QoS; then reliable; then both at once; then one alone.
  const dds_entity_t first = robot.writer(kImage, "rt/image", true);
  ASSERT_TRUE(has_reader(source, first));
  EXPECT_EQ(value_of_next(source, first, 5), 5);
  dds_delete(first);
  ASSERT_TRUE(wait_until([&] { return source.next(0.01), !source.has_publisher(); }));
  dds_entity_t sensor = robot.writer(kImage, "rt/image", false);
  EXPECT_EQ(value_of_next(source, sensor, 10), 10);
  dds_delete(sensor);
  ASSERT_TRUE(wait_until([&] { return source.next(0.01), !source.has_publisher(); }));
  const dds_entity_t reliable = robot.writer(kImage, "rt/image", true);
  EXPECT_EQ(value_of_next(source, reliable, 20), 20);
  const Ros2Peer other(domain);
  sensor = other.writer(kImage, "rt/image", false);
  EXPECT_EQ(value_of_next(source, sensor, 30), 30);
  EXPECT_EQ(value_of_next(source, reliable, 40), 40);
  dds_delete(reliable);
  EXPECT_EQ(value_of_next(source, sensor, 50), 50);
  EXPECT_TRUE(source.rejected().empty());
}

/// A reliable publisher: what packets are lost is sent again, and images come in order.
TEST(Ros2Images, ImagesOfAReliablePublisherSurviveLostPackets) {
  const LoopbackDomain domain;
  ImageSource source("/image");
  const Ros2Peer robot(domain, 50);  // one packet of twenty is lost; an image has some 60
  const dds_entity_t writer = robot.writer(kImage, "rt/image");
  ASSERT_TRUE(has_reader(source, writer));
  ASSERT_TRUE(in_step(source, [&] { write_image(writer, grey_image(0.5, 0)); }));
  int last = 0;
  for (int i = 1; i <= 10; ++i) {
    write_image(writer, grey_image(i, i, 320, 240));
    const auto image = source.next(8);
    ASSERT_TRUE(image) << i;
    EXPECT_GT(int(image->pixels.at(319, 239)), last);
    last = image->pixels.at(0, 0);
    EXPECT_EQ(image->stamp, last);
  }
}

/// A latched image (a map's picture) that was published long before.
TEST(Ros2Images, WhatAPublisherKeepsForLateReadersArrives) {
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  const dds_entity_t writer = robot.writer(kImage, "rt/map_image", true, true);
  write_image(writer, grey_image(3, 77));
  ImageSource source("/map_image");
  const auto image = source.next(8);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->pixels.at(2, 2), 77);
}

TEST(Ros2Images, CompressedImagesAreReadByTheirPublishedType) {
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  ImageSource source("/image/compressed");
  const dds_entity_t writer = robot.writer(kCompressed, "rt/image/compressed", false);
  ASSERT_TRUE(has_reader(source, writer));
  ImageU8 sent(9, 5, 3);
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 9; ++x)
      for (int k = 0; k < 3; ++k) sent.at(x, y, k) = std::uint8_t(20 * x + 7 * y + 40 * k);
  const std::string png = io::encode_png(sent);
  ASSERT_TRUE(in_step(source, [&] { test::write_compressed(writer, 1, png); }));
  test::write_compressed(writer, 4, png.substr(0, png.size() / 2));
  test::write_compressed(writer, 5, "GIF89a", "gif");
  test::write_compressed(writer, 6, io::encode_png(ImageU8(4200, 4200, 1)));
  test::write_compressed(writer, 7, png);
  const auto image = source.next(8);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->stamp, 7);
  EXPECT_TRUE(std::equal(sent.data(), sent.data() + 135, image->pixels.data()));
  const std::map<std::string, std::uint64_t> expected = {
      {"ros2_invalid_image", 1}, {"ros2_unknown_encoding", 1}, {"ros2_oversized", 1}};
  EXPECT_EQ(source.rejected(), expected);
}

/// Stamps are every 100 ms; the network delays by up to 60 ms more than the least.
TEST(Ros2Images, TheJitterOfTheNetworkIsTakenAway) {
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  ImageSource source("/image");
  const dds_entity_t writer = robot.writer(kImage, "rt/image");
  ASSERT_TRUE(has_reader(source, writer));
  const double sender = 1700000000 - steady_now();  // its clock less this one
  ASSERT_TRUE(in_step(source, [&] { write_image(writer, grey_image(sender + steady_now(), 0)); }));
  const double begin = steady_now() + 0.05;
  std::vector<double> late;
  for (int i = 0; i < 25; ++i) {
    const double delay = i % 3 == 0 ? 0 : i % 3 == 1 ? 0.06 : 0.03;
    while (steady_now() < begin + 0.1 * i + delay)
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    write_image(writer, grey_image(sender + begin + 0.1 * i, i));
    const auto image = source.next(8);
    ASSERT_TRUE(image);
    if (i > 5) late.push_back(image->time - begin - 0.1 * i);
  }
  for (const double one : late)
    EXPECT_NEAR(one, late.front(), 0.02);  // of a busy machine; the jitter is 0.06
}

TEST(Ros2Images, WhatIsNoImageIsCountedByItsCauseAndTheNextOneArrives) {
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  ImageSource source("/image");
  const dds_entity_t writer = robot.writer(kImage, "rt/image");
  ASSERT_TRUE(has_reader(source, writer));
  ASSERT_TRUE(in_step(source, [&] { write_image(writer, grey_image(1, 9)); }));
  const auto send = [&](const std::function<void(ImageMessage&)>& change) {
    ImageMessage message = grey_image(1, 9);
    change(message);
    write_image(writer, message);
    EXPECT_FALSE(source.next(0.02));
  };
  send([](ImageMessage& m) { m.step = 5; });
  send([](ImageMessage& m) { m.data.pop_back(); });
  send([](ImageMessage& m) { m.width = m.height = 0; });
  send([](ImageMessage& m) { m.width = m.step = 0xffffffffu; });
  send([](ImageMessage& m) { m.encoding = "64FC4"; });
  send([](ImageMessage& m) { m.encoding = ""; });
  // A stamp that is none.
  sensor_msgs_msg_dds__Image_ wrong{};
  char text[] = "mono8";
  wrong.header.frame_id = wrong.encoding = text;
  wrong.header.stamp.nanosec = 2'000'000'000;
  EXPECT_EQ(dds_write(writer, &wrong), DDS_RETCODE_OK);
  // The type's name is right, and the bytes are those of another type; the topic's is, and the type is not.
  dds_topic_descriptor_t forged = tf2_msgs_msg_dds__TFMessage__desc;
  forged.m_typename = kImage.m_typename;
  const Ros2Peer forger(domain), stranger(domain);
  const dds_entity_t forged_writer = forger.writer(forged, "rt/image");
  EXPECT_GT(stranger.writer(sensor_msgs_msg_dds__CameraInfo__desc, "rt/image"), 0);
  ASSERT_TRUE(has_reader(source, forged_writer));
  ASSERT_TRUE(wait_until([&] {
    const tf2_msgs_msg_dds__TFMessage_ none{};
    EXPECT_EQ(dds_write(forged_writer, &none), DDS_RETCODE_OK);
    source.next(0.05);
    return source.rejected()["ros2_undecodable"] > 0;
  }));
  EXPECT_TRUE(wait_until([&] { return source.next(0.01), source.rejected()["ros2_foreign_type"] == 1; }));
  std::map<std::string, std::uint64_t> rejected = source.rejected();
  EXPECT_GE(rejected["ros2_undecodable"], 1u);
  rejected.erase("ros2_undecodable");
  const std::map<std::string, std::uint64_t> expected = {{"ros2_invalid_image", 3},
                                                         {"ros2_oversized", 1},
                                                         {"ros2_unknown_encoding", 2},
                                                         {"ros2_invalid_stamp", 1},
                                                         {"ros2_foreign_type", 1}};
  EXPECT_EQ(rejected, expected);
  EXPECT_EQ(value_of_next(source, writer, 123), 123);
}

/// DDS puts no sample together that is longer than the limit: the memory of one is not taken.
TEST(Ros2Images, ASampleAboveTheLimitIsDroppedAndCounted) {
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  ImageSource source("/image");
  const dds_entity_t writer = robot.writer(kImage, "rt/image");
  ASSERT_TRUE(has_reader(source, writer));
  ImageMessage message = grey_image(1, 9);
  message.data.resize(limits::kDdsSampleBytes + 1000);
  EXPECT_TRUE(wait_until([&] {
    write_image(writer, message);
    source.next(0.2);
    return source.rejected()["ros2_oversized"] > 0;
  }));
  EXPECT_EQ(value_of_next(source, writer, 123), 123);
}

TEST(Ros2Depth, DepthComesWithItsUnitAndTheLensOfCameraInfo) {
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  DepthImageSource source("/camera/depth/image_raw");
  const dds_entity_t images = robot.writer(kImage, "rt/camera/depth/image_raw", false);
  const dds_entity_t infos =
      robot.writer(sensor_msgs_msg_dds__CameraInfo__desc, "rt/camera/depth/camera_info", false);
  ASSERT_TRUE(has_reader(source, images));
  ImageMessage message;
  message.width = 4;
  message.height = 2;
  message.step = 8;
  message.encoding = "16UC1";
  message.stamp = 7.5;
  for (int i = 0; i < 8; ++i) {
    message.data.push_back(std::uint8_t(i));
    message.data.push_back(4);
  }
  ASSERT_TRUE(in_step(source, [&] { write_image(images, message); }));
  const double sent = steady_now();
  write_image(images, message);
  std::optional<ReceivedDepth> depth = source.next(8);
  ASSERT_TRUE(depth);
  EXPECT_EQ(depth->stamp, 7.5);
  EXPECT_GE(depth->arrival, sent);
  EXPECT_EQ(depth->metres_per_unit, 1e-3);
  EXPECT_EQ(std::get<Image<std::uint16_t>>(depth->pixels).at(1, 1), 0x0405);
  EXPECT_FALSE(depth->camera);
  const auto next_lens = [&](std::uint32_t width, double fx) {
    return wait_until([&] {
      test::write_camera_info(infos, width, 2, fx, 1.25, {-0.1, 0.02, 0.003, -0.004, 0.0005});
      write_image(images, message);
      depth = source.next(0.2);
      return depth && depth->camera && depth->camera->intrinsics.fx == fx;
    });
  };
  ASSERT_TRUE(next_lens(4, 3.5));
  EXPECT_EQ(depth->camera->size, (ImageSize{4, 2}));
  EXPECT_EQ(depth->camera->intrinsics.skew, 1.25);
  EXPECT_EQ(coefficients_of(depth->camera->distortion),
            (std::vector<double>{-0.1, 0.02, 0.003, -0.004, 0.0005}));
  // One of another size does not belong to the images; one that is wrong is counted.
  for (const bool is_wrong : {false, true}) {
    EXPECT_TRUE(wait_until([&] {
      test::write_camera_info(infos, is_wrong ? 4 : 640, is_wrong ? 2 : 480, 3.5, 0,
                              std::vector<double>(is_wrong ? 7 : 5, 0.1));
      write_image(images, message);
      depth = source.next(0.2);
      // Its info may arrive after its image.
      const bool is_counted = source.rejected().count("ros2_invalid_camera_info") > 0;
      return depth && !depth->camera && is_counted == is_wrong;
    }));
  }
  EXPECT_TRUE(next_lens(4, 4.5));
  // Metres, and what is no depth.
  message.encoding = "32FC1";
  message.width = 2;
  message.data = {0, 0, 0xa0, 0x3f, 0, 0, 0xc0, 0x7f, 0, 0, 0, 0, 0, 0, 0, 0x40};
  write_image(images, message);
  depth = source.next(8);
  ASSERT_TRUE(depth);
  EXPECT_FALSE(depth->metres_per_unit);
  const ImageF& metres = std::get<ImageF>(depth->pixels);
  EXPECT_EQ(metres.at(0, 0), 1.25f);
  EXPECT_EQ(metres.at(1, 0), 0) << "not a number";
  EXPECT_EQ(metres.at(1, 1), 2);
  message.encoding = "bgr8";
  write_image(images, message);
  EXPECT_FALSE(source.next(0.1));
  EXPECT_EQ(source.rejected()["ros2_unknown_encoding"], 1u);
}

/// Poses of a topic follow their publisher's QoS as images do.
TEST(Ros2Graph, APoseTopicWhosePublisherBecomesBestEffortIsFollowed) {
  const LoopbackDomain domain;
  const auto source = open_pose_source("ros2:/vicon");
  for (const bool is_reliable : {true, false, true}) {
    const Ros2Peer robot(domain);
    const dds_entity_t writer =
        robot.writer(geometry_msgs_msg_dds__PoseStamped__desc, "rt/vicon", is_reliable);
    geometry_msgs_msg_dds__PoseStamped_ message{};
    char frame[] = "map";
    message.header.frame_id = frame;
    message.pose.orientation.w = 1;
    std::vector<track::StampedPose> arrived;
    EXPECT_TRUE(wait_until([&] {
      EXPECT_EQ(dds_write(writer, &message), DDS_RETCODE_OK);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      source->poll(arrived);
      return !arrived.empty();
    })) << is_reliable;
    EXPECT_TRUE(source->status().connected);
    dds_delete(robot.participant());
    EXPECT_TRUE(wait_until([&] { return !source->status().connected; }));
    source->poll(arrived);
  }
}

}  // namespace
}  // namespace procam::dds
