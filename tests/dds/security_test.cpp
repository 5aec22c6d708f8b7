// DDS Security: who takes part in the graph, and what is read on the network. Certificates are made for each test.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "graph_values.hpp"
#include "keystore.hpp"
#include "procam/dds/image_source.hpp"
#include "procam/dds/pose_source.hpp"
#include "procam/dds/projector_publisher.hpp"
#include "procam/dds/security.hpp"
#include "ros2_peer.hpp"
#include "security.hpp"
#include "support/expect_error.hpp"

namespace procam::dds {
namespace {

using test::contains;
using test::Keystore;
using test::LoopbackDomain;
using test::Ros2Peer;

class DdsSecurity : public testing::Test {
 protected:
  ~DdsSecurity() override { use_security({}); }
  static void send(dds_entity_t writer, double x) {
    std::string frame = "secret_map", child = "base_link";
    geometry_msgs_msg_dds__TransformStamped_ one{};
    one.header.stamp.sec = 1700000000;
    one.header.frame_id = frame.data();
    one.child_frame_id = child.data();
    one.transform.translation.x = x;
    one.transform.rotation.w = 1;
    tf2_msgs_msg_dds__TFMessage_ message{};
    message.transforms._length = message.transforms._maximum = 1;
    message.transforms._buffer = &one;
    EXPECT_EQ(dds_write(writer, &message), DDS_RETCODE_OK);
  }
  /// Each knows of the other: keys are exchanged in both directions.
  static bool are_matched(dds_entity_t writer, const track::PoseSource& source) {
    return test::is_connected(source) && test::wait_until([&] {
             dds_publication_matched_status_t matched;
             return dds_get_publication_matched_status(writer, &matched) == DDS_RETCODE_OK &&
                    matched.current_count == 1;
           });
  }
  /// Of a participant of `enclave`.
  static internal::Security secured(const std::filesystem::path& enclave) {
    use_security(enclave);
    return internal::security_of_process();
  }
  /// All that a peer sent and received, as it was on the network.
  static std::string captured(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
};

TEST_F(DdsSecurity, OnlyACertifiedRobotMovesTheContent) {
  const LoopbackDomain domain;
  const Keystore ours, theirs;
  const internal::Security of_forger = secured(theirs.enclave("projector")),
                           of_robot = secured(ours.enclave("robot"));
  use_security(ours.enclave("projector"));
  const auto source = open_pose_source("ros2:secret_map,base_link");
  EXPECT_TRUE(contains(source->description(), ", DDS Security by ")) << source->description();
  {
    const Ros2Peer stranger(domain), forger(domain, 0, of_forger.qos.get());
    const dds_entity_t from_stranger = stranger.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf");
    const dds_entity_t from_forger = forger.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf");
    for (int i = 0; i < 150; ++i) {
      send(from_stranger, 1);
      send(from_forger, 2);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    std::vector<track::StampedPose> arrived;
    source->poll(arrived);
    EXPECT_TRUE(arrived.empty());
    EXPECT_EQ(source->status().connections, 0u);
  }
  // Another part of this process: it meets the robot, too.
  ProjectorPublisher publisher("ros2:/procam");
  publisher.publish_frames({{"base_link", "procam/rig", {test::some_pose(9), Mat6::Zero()}}}, 1);
  const Ros2Peer robot(domain, 0, of_robot.qos.get());
  const dds_entity_t frames = robot.reader(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf_static", true, true);
  const dds_entity_t tf = robot.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf");
  ASSERT_TRUE(are_matched(tf, *source)) << source->status().last_error;
  send(tf, 3);
  const auto poses = test::next_poses(*source);
  ASSERT_EQ(poses.size(), 1u);
  EXPECT_EQ(poses[0].frame_from_child.translation.x(), 3);
  void* samples[1] = {};
  dds_sample_info_t info;
  ASSERT_TRUE(test::wait_until([&] { return dds_take(frames, samples, &info, 1, 1) == 1; }));
  EXPECT_STREQ(
      static_cast<const tf2_msgs_msg_dds__TFMessage_*>(samples[0])->transforms._buffer[0].child_frame_id,
      "procam/rig");
  dds_return_loan(frames, samples, 1);
}

TEST_F(DdsSecurity, MessagesAreEncryptedOnTheNetwork) {
  const Keystore keystore;
  for (const bool is_secured : {false, true}) {
    const LoopbackDomain domain;
    const auto capture = keystore.folder() / (is_secured ? "secured.pcap" : "open.pcap");
    const internal::Security of_robot = secured(is_secured ? keystore.enclave("robot") : "");
    use_security(is_secured ? keystore.enclave("projector") : "");
    {
      const auto source = open_pose_source("ros2:secret_map,base_link");
      const Ros2Peer robot(domain, 0, of_robot.qos.get(), capture.string());
      const dds_entity_t tf = robot.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf");
      ASSERT_TRUE(are_matched(tf, *source));
      send(tf, 4);
      ASSERT_EQ(test::next_poses(*source).size(), 1u);
    }
    EXPECT_GT(captured(capture).size(), 5000u);
    EXPECT_EQ(contains(captured(capture), "secret_map"), !is_secured);
    EXPECT_EQ(contains(captured(capture), "tf2_msgs"), !is_secured) << "types and topics";
  }
}

TEST_F(DdsSecurity, APermissionThatLacksATopicNamesIt) {
  const LoopbackDomain domain;
  const Keystore keystore;
  use_security(keystore.enclave("projector", "rt/tf*"));
  EXPECT_NO_THROW(open_pose_source("ros2:map,base_link"));
  EXPECT_ERROR(ProjectorPublisher("ros2:/procam").publish_health({}, 1), kDevice,
               "allow the topic rt/diagnostics in the permissions");
}

TEST_F(DdsSecurity, FilesThatDoNotFitAreRefused) {
  const LoopbackDomain domain;
  const Keystore ours, theirs;
  EXPECT_ERROR(use_security("/none"), kInput, "'/none': it is no folder");
  const auto enclave = ours.enclave("projector");
  std::filesystem::remove(enclave / "governance.p7s");
  EXPECT_ERROR(use_security(enclave), kInput, "it has no file governance.p7s");
  const auto other = ours.enclave("projector");
  std::filesystem::copy_file(theirs.enclave("projector") / "permissions.p7s", other / "permissions.p7s",
                             std::filesystem::copy_options::overwrite_existing);
  use_security(other);
  EXPECT_ERROR(open_pose_source("ros2:map,base_link"), kDevice, "its certificates are of one authority");
  // The environment of a robot asks for it too, and is not ignored.
  use_security({});
  ::setenv("ROS_SECURITY_ENABLE", "true", 1);
  EXPECT_ERROR(ImageSource("/image"), kInput, "ROS_SECURITY_KEYSTORE names no folder");
  ::setenv("ROS_SECURITY_KEYSTORE", ours.folder().c_str(), 1);
  ::setenv("ROS_SECURITY_ENCLAVE_OVERRIDE", "/camera", 1);
  EXPECT_ERROR(ImageSource("/image"), kInput, "/enclaves/camera': it is no folder");
  ours.enclave("camera");
  EXPECT_TRUE(contains(ImageSource("/image").description(), "/enclaves/camera"));
  for (const char* name : {"ENABLE", "KEYSTORE", "ENCLAVE_OVERRIDE"})
    ::unsetenv((std::string("ROS_SECURITY_") + name).c_str());
}

}  // namespace
}  // namespace procam::dds
