// Poses of the ROS 2 graph: real DDS traffic through sockets of the loopback interface, written by a second DDS domain.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <ctime>
#include <functional>
#include <limits>
#include <optional>
#include <thread>
#include <vector>

#include "dds/ddsi/ddsi_serdata.h"
#include "graph_values.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/dds/pose_source.hpp"
#include "procam/dds/projector_publisher.hpp"
#include "ros2_peer.hpp"
#include "support/expect_error.hpp"

namespace procam::dds {
namespace {

using test::Cdr;
using test::expect_equal;
using test::is_connected;
using test::left_covariance;
using test::lens_shifted_projector;
using test::LoopbackDomain;
using test::next_poses;
using test::Ros2Peer;
using test::some_pose;
using test::some_ros_covariance;
using test::wait_until;
using track::StampedPose;

bool has_readers(dds_entity_t writer, std::uint32_t count = 1) {
  return wait_until([&] {
    dds_publication_matched_status_t matched;
    return dds_get_publication_matched_status(writer, &matched) == DDS_RETCODE_OK &&
           matched.current_count >= count;
  });
}

bool has_writer(dds_entity_t reader) {
  return wait_until([&] {
    dds_subscription_matched_status_t matched;
    return dds_get_subscription_matched_status(reader, &matched) == DDS_RETCODE_OK &&
           matched.current_count >= 1;
  });
}

/// A message that keeps the texts which the C structures point to.
class Transforms {
 public:
  Transforms& add(std::string frame, std::string child, double stamp, const Pose& pose) {
    texts_.push_back(std::make_unique<std::array<std::string, 2>>(
        std::array<std::string, 2>{std::move(frame), std::move(child)}));
    geometry_msgs_msg_dds__TransformStamped_ one{};
    one.header.stamp.sec = std::int32_t(std::floor(stamp));
    one.header.stamp.nanosec = std::uint32_t(std::lround(1e9 * (stamp - std::floor(stamp))));
    one.header.frame_id = texts_.back()->at(0).data();
    one.child_frame_id = texts_.back()->at(1).data();
    one.transform.translation = {pose.translation.x(), pose.translation.y(), pose.translation.z()};
    const Eigen::Quaterniond& q = pose.rotation;
    one.transform.rotation = {q.x(), q.y(), q.z(), q.w()};
    transforms_.push_back(one);
    return *this;
  }
  tf2_msgs_msg_dds__TFMessage_ message() {
    tf2_msgs_msg_dds__TFMessage_ message{};
    message.transforms._length = message.transforms._maximum = std::uint32_t(transforms_.size());
    message.transforms._buffer = transforms_.data();
    return message;
  }
  void write(dds_entity_t writer) {
    const tf2_msgs_msg_dds__TFMessage_ sample = message();
    EXPECT_EQ(dds_write(writer, &sample), DDS_RETCODE_OK);
  }

 private:
  std::vector<std::unique_ptr<std::array<std::string, 2>>> texts_;
  std::vector<geometry_msgs_msg_dds__TransformStamped_> transforms_;
};

TEST(Ros2Graph, APoseOnTfArrivesAsItWasSentAndAtOnce) {
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  const auto source = open_pose_source("ros2:map,base_link");
  EXPECT_EQ(source->description(),
            "ROS 2 domain " + std::to_string(domain.number()) +
                ", network lo (127.0.0.1): 'base_link' in 'map' from /tf and /tf_static");
  EXPECT_TRUE(test::contains(source->status().last_error, "no publisher of /tf"))
      << source->status().last_error;
  EXPECT_FALSE(source->status().connected);
  const dds_entity_t tf = robot.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf");
  ASSERT_TRUE(has_readers(tf) && is_connected(*source));
  const double sent = steady_now();
  Transforms().add("map", "base_link", 1700000000.25, some_pose(1)).write(tf);
  const std::vector<StampedPose> poses = next_poses(*source);
  ASSERT_EQ(poses.size(), 1u);
  EXPECT_EQ(poses[0].frame + " " + poses[0].child, "map base_link");
  EXPECT_EQ(poses[0].stamp, 1700000000.25);
  expect_equal(poses[0].frame_from_child, some_pose(1));
  EXPECT_GE(poses[0].arrival, sent);
  EXPECT_FALSE(poses[0].covariance);
  EXPECT_TRUE(source->status().connected);
  EXPECT_EQ(source->status().malformed, 0u);
  // An unrelated edge gives no further pose; the publisher that ends is noticed.
  Transforms().add("base_link", "wheel", 1700000000.5, some_pose(2)).write(tf);
  Transforms().add("map", "base_link", 1700000000.75, some_pose(3)).write(tf);
  const std::vector<StampedPose> later = next_poses(*source);
  ASSERT_EQ(later.size(), 1u);
  EXPECT_EQ(later[0].stamp, 1700000000.75);
  dds_delete(tf);
  EXPECT_TRUE(wait_until([&] { return !source->status().connected; }));
}

TEST(Ros2Graph, ALateSourceGetsStaticFramesAndInterpolatesTheChain) {
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  const dds_entity_t tf_static =
      robot.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/robot1/tf_static", true, true);
  const dds_entity_t tf = robot.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/robot1/tf");
  // Long before the source; a second publisher of static frames as well.
  Transforms().add("base_link", "projector", 0, some_pose(7)).write(tf_static);
  const Ros2Peer other(domain);
  const dds_entity_t other_static =
      other.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/robot1/tf_static", true, true);
  Transforms().add("earth", "map", 0, some_pose(8)).write(other_static);
  const auto source = open_pose_source("ros2:earth,projector,__ns:=/robot1,/tf:=tf,/tf_static:=tf_static");
  ASSERT_TRUE(has_readers(tf) && is_connected(*source, 3));
  ASSERT_TRUE(has_readers(tf_static));
  ASSERT_TRUE(has_readers(other_static));
  // As AMCL does: map -> odom comes seldom, and speaks of the future.
  Transforms().add("map", "odom", 100, some_pose(1)).add("odom", "base_link", 99.5, some_pose(3)).write(tf);
  Transforms().add("map", "odom", 101, some_pose(2)).write(tf);
  // At 99.5 the first is not known: nothing is extrapolated.
  Transforms().add("odom", "base_link", 100.25, some_pose(4)).write(tf);
  std::vector<StampedPose> poses = next_poses(*source);
  ASSERT_EQ(poses.size(), 1u);
  EXPECT_EQ(poses[0].stamp, 100.25);
  Transforms().add("odom", "base_link", 100.5, some_pose(5)).write(tf);
  poses = next_poses(*source);
  ASSERT_EQ(poses.size(), 1u);
  EXPECT_EQ(poses[0].stamp, 100.5);
  Pose map_from_odom;
  map_from_odom.rotation = some_pose(1).rotation.slerp(0.5, some_pose(2).rotation);
  map_from_odom.translation = 0.5 * (some_pose(1).translation + some_pose(2).translation);
  expect_equal(poses[0].frame_from_child, some_pose(8) * map_from_odom * some_pose(5) * some_pose(7));
  EXPECT_EQ(poses[0].frame + " " + poses[0].child, "earth projector");
}

template <typename Message>
void fill_pose(Message& message, const Pose& pose, const Mat6& ros) {
  message.pose.pose.position = {pose.translation.x(), pose.translation.y(), pose.translation.z()};
  message.pose.pose.orientation = {pose.rotation.x(), pose.rotation.y(), pose.rotation.z(),
                                   pose.rotation.w()};
  for (int i = 0; i < 36; ++i) message.pose.covariance[i] = ros(i / 6, i % 6);
}

TEST(Ros2Graph, OdometryOfABestEffortPublisherBringsTwistAndCovariance) {
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  const auto source = open_pose_source("ros2:/odom");
  const dds_entity_t odom = robot.writer(nav_msgs_msg_dds__Odometry__desc, "rt/odom", false);
  ASSERT_TRUE(has_readers(odom) && is_connected(*source));
  nav_msgs_msg_dds__Odometry_ message{};
  char frame[] = "odom", child[] = "chassis";
  message.header.stamp = {12, 500'000'000};
  message.header.frame_id = frame;
  message.child_frame_id = child;
  fill_pose(message, some_pose(2), some_ros_covariance());
  message.twist.twist.linear = {0.5, -0.1, 0.02};
  message.twist.twist.angular = {0.01, 0.03, -0.4};
  ASSERT_EQ(dds_write(odom, &message), DDS_RETCODE_OK);
  const std::vector<StampedPose> poses = next_poses(*source);
  ASSERT_EQ(poses.size(), 1u);
  EXPECT_EQ(poses[0].frame + " " + poses[0].child, "odom chassis");
  EXPECT_EQ(poses[0].stamp, 12.5);
  expect_equal(poses[0].frame_from_child, some_pose(2));
  ASSERT_TRUE(poses[0].twist);
  EXPECT_EQ(*poses[0].twist, (Vec6() << 0.01, 0.03, -0.4, 0.5, -0.1, 0.02).finished());
  ASSERT_TRUE(poses[0].covariance);
  const Mat6 expected = left_covariance(some_ros_covariance(), some_pose(2));
  EXPECT_LT((*poses[0].covariance - expected).cwiseAbs().maxCoeff(), 1e-8 * expected.cwiseAbs().maxCoeff());
}

TEST(Ros2Graph, PosesWithCovarianceAndStampedPosesAreReadByTheirPublishedType) {
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  const auto amcl_source = open_pose_source("ros2:/amcl_pose");
  const auto vicon_source = open_pose_source("ros2:/vicon/pose");
  const dds_entity_t amcl =
      robot.writer(geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc, "rt/amcl_pose");
  const dds_entity_t vicon = robot.writer(geometry_msgs_msg_dds__PoseStamped__desc, "rt/vicon/pose", false);
  ASSERT_TRUE(has_readers(amcl) && is_connected(*amcl_source));
  ASSERT_TRUE(has_readers(vicon) && is_connected(*vicon_source));
  geometry_msgs_msg_dds__PoseWithCovarianceStamped_ message{};
  char frame[] = "/map";
  message.header.frame_id = frame;
  message.header.stamp = {7, 0};
  fill_pose(message, some_pose(4), some_ros_covariance());
  ASSERT_EQ(dds_write(amcl, &message), DDS_RETCODE_OK);
  const std::vector<StampedPose> poses = next_poses(*amcl_source);
  ASSERT_EQ(poses.size(), 1u);
  EXPECT_EQ(poses[0].frame + " " + poses[0].child, "map base_link");
  ASSERT_TRUE(poses[0].covariance);
  const Mat6 expected = left_covariance(some_ros_covariance(), some_pose(4));
  EXPECT_LT((*poses[0].covariance - expected).cwiseAbs().maxCoeff(), 1e-8 * expected.cwiseAbs().maxCoeff());

  geometry_msgs_msg_dds__PoseStamped_ bare{};
  bare.header.frame_id = frame;  // without a stamp: the time of its writing, which is Unix time
  bare.pose = message.pose.pose;
  ASSERT_EQ(dds_write(vicon, &bare), DDS_RETCODE_OK);
  const std::vector<StampedPose> bare_poses = next_poses(*vicon_source);
  ASSERT_EQ(bare_poses.size(), 1u);
  ASSERT_TRUE(bare_poses[0].stamp);
  const double now =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  EXPECT_NEAR(*bare_poses[0].stamp, now, 10);
  expect_equal(bare_poses[0].frame_from_child, some_pose(4));
}

/// A simulation at four times the speed, that stands for a while and begins again.
TEST(Ros2Graph, SimulatedTimeIsFollowedThroughPausesAndJumps) {
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  const dds_entity_t clock = robot.writer(rosgraph_msgs_msg_dds__Clock__desc, "rt/clock");
  const dds_entity_t tf = robot.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf");
  const dds_entity_t tf_static = robot.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf_static", true, true);
  Transforms().add("base_link", "lamp", 0, some_pose(7)).write(tf_static);
  const auto source = open_pose_source("ros2:map,lamp,use_sim_time:=true");
  EXPECT_TRUE(test::contains(source->description(), "by the simulated time of /clock"))
      << source->description();
  ASSERT_TRUE(has_readers(clock) && has_readers(tf) && is_connected(*source, 2));
  const auto tick = [&](double time) {
    const rosgraph_msgs_msg_dds__Clock_ sample{
        {std::int32_t(std::floor(time)), std::uint32_t(std::lround(1e9 * (time - std::floor(time))))}};
    EXPECT_EQ(dds_write(clock, &sample), DDS_RETCODE_OK);
  };
  std::vector<StampedPose> poses, arrived;
  const auto take = [&] {
    source->poll(arrived);
    poses.insert(poses.end(), arrived.begin(), arrived.end());
  };
  // Stamps of the future and the past of here, by 40 ms of simulated time every 10 ms.
  const auto drive = [&](double begin, int steps) {
    for (int k = 0; k < steps; ++k) {
      const double time = begin + 0.04 * k;
      tick(time);
      Transforms().add("map", "base_link", time, some_pose(k)).write(tf);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      take();
    }
    // On a busy machine the last one takes its time.
    const Pose last = some_pose(steps - 1) * some_pose(7);
    EXPECT_TRUE(wait_until([&] {
      take();
      return !poses.empty() && poses.back().frame_from_child.translation.isApprox(last.translation, 1e-9);
    }));
  };
  // A busy machine may read a clock message long before the pose of the same moment, but then poses are that far apart too.
  const auto expect_local_stamps = [&] {
    double longest_gap_s = 0;
    for (std::size_t i = 1; i < poses.size(); ++i) {
      longest_gap_s = std::max(longest_gap_s, poses[i].arrival - poses[i - 1].arrival);
      EXPECT_GE(*poses[i].stamp, *poses[i - 1].stamp);
    }
    for (const StampedPose& pose : poses)
      EXPECT_NEAR(*pose.stamp, pose.arrival, 0.05 + longest_gap_s) << "stamps are of the local clock";
  };
  // What a reliable writer sends before its first heartbeat is handed on 0.1 s later.
  drive(5000 - 0.04 * 20, 20);
  poses.clear();
  const double begin = steady_now();
  drive(5000, 40);
  ASSERT_GE(poses.size(), 30u);
  expect_local_stamps();
  EXPECT_LT(*poses.back().stamp - *poses.front().stamp, steady_now() - begin)
      << "1.6 s of simulated time are 0.4 s of local time, or as long as a busy machine took";
  expect_equal(poses.back().frame_from_child, some_pose(39) * some_pose(7));
  // The simulation pauses: the pose does not grow old.
  poses.clear();
  EXPECT_TRUE(wait_until([&] {
    tick(5000 + 0.04 * 39);
    take();
    return poses.size() >= 10 && *poses.back().stamp - *poses.front().stamp > 0.1;
  }));
  ASSERT_FALSE(poses.empty());
  expect_equal(poses.back().frame_from_child, some_pose(39) * some_pose(7));
  // It is set back: the frames that move are known anew, the static ones still.
  poses.clear();
  tick(5000.8);
  ASSERT_TRUE(wait_until([&] { return test::contains(source->status().last_error, "has jumped"); }));
  drive(5000.8, 10);
  ASSERT_GE(poses.size(), 5u);
  expect_equal(poses.back().frame_from_child, some_pose(9) * some_pose(7));
  expect_local_stamps();
}

/// Half a metre a simulated second, at four times the speed, are two metres a second here.
TEST(Ros2Graph, TwistsAreScaledToTheRateOfSimulatedTime) {
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  const dds_entity_t clock = robot.writer(rosgraph_msgs_msg_dds__Clock__desc, "rt/clock");
  const dds_entity_t odom = robot.writer(nav_msgs_msg_dds__Odometry__desc, "rt/odom");
  const auto source = open_pose_source("ros2:/odom,use_sim_time:=true");
  ASSERT_TRUE(has_readers(clock) && has_readers(odom) && is_connected(*source));
  std::vector<StampedPose> poses, arrived;
  char frame[] = "odom", child[] = "base_link";
  for (int k = 0; k < 50; ++k) {
    const double time = 5000 + 0.04 * k;
    nav_msgs_msg_dds__Odometry_ message{};
    message.header.stamp = {std::int32_t(std::floor(time)), std::uint32_t(1e9 * (time - std::floor(time)))};
    message.header.frame_id = frame;
    message.child_frame_id = child;
    message.pose.pose.position = {0.5 * time, 0, 0};
    message.pose.pose.orientation.w = 1;
    message.twist.twist.linear.x = 0.5;
    const rosgraph_msgs_msg_dds__Clock_ now{message.header.stamp};
    EXPECT_EQ(dds_write(clock, &now), DDS_RETCODE_OK);
    EXPECT_EQ(dds_write(odom, &message), DDS_RETCODE_OK);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    source->poll(arrived);
    poses.insert(poses.end(), arrived.begin(), arrived.end());
  }
  ASSERT_GE(poses.size(), 30u);
  const StampedPose &first = poses.front(), &last = poses.back();
  const double speed = (last.frame_from_child.translation.x() - first.frame_from_child.translation.x()) /
                       (*last.stamp - *first.stamp);
  EXPECT_GT(speed, 0.7) << "2 m/s, less where the machine is busy; unscaled it is 0.5";
  EXPECT_NEAR((*last.twist)[3], speed, 0.2 * speed);
}

TEST(Ros2Graph, LostPacketsAreSentAgainAndARestartedRobotIsFollowed) {
  const LoopbackDomain domain;
  const auto source = open_pose_source("ros2:map,base_link");
  std::vector<StampedPose> poses;
  {
    const Ros2Peer robot(domain, 100);  // one packet of ten is lost
    const dds_entity_t tf = robot.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf");
    ASSERT_TRUE(has_readers(tf) && is_connected(*source));
    for (int i = 0; i < 100; ++i) {
      Transforms().add("map", "base_link", 1000 + 0.125 * i, some_pose(0.1 * i)).write(tf);
      std::this_thread::sleep_for(std::chrono::milliseconds(3));
    }
    poses = next_poses(*source, 100);
  }
  ASSERT_EQ(poses.size(), 100u);
  for (std::size_t i = 0; i < poses.size(); ++i) EXPECT_EQ(poses[i].stamp, 1000 + 0.125 * double(i));
  // Its farewell may be among the lost packets. Then its lease of ten seconds runs out.
  EXPECT_TRUE(wait_until([&] { return !source->status().connected; }, 20));
  // Its clock begins anew.
  const Ros2Peer robot(domain);
  const dds_entity_t tf = robot.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf");
  ASSERT_TRUE(has_readers(tf) && is_connected(*source, 2));
  Transforms().add("map", "base_link", 3.5, some_pose(2)).write(tf);
  poses = next_poses(*source);
  ASSERT_EQ(poses.size(), 1u);
  EXPECT_EQ(poses[0].stamp, 3.5);
}

TEST(Ros2Graph, WhatIsNoMessageIsCountedByItsCauseAndTheNextPoseArrives) {
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  const auto source = open_pose_source("ros2:map,base_link");
  const dds_entity_t tf = robot.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf");
  ASSERT_TRUE(has_readers(tf) && is_connected(*source));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto with = [](double x, double qw) {
    Pose pose = some_pose(1);
    pose.translation.x() = x;
    if (qw != 0) pose.rotation.coeffs() << 0, 0, 0, qw;
    return pose;
  };
  Transforms().add("map", "base_link", 1, with(nan, 0)).write(tf);
  Transforms().add("map", "base_link", 1, with(2e6, 0)).write(tf);
  Transforms().add("map", "base_link", 1, with(1, 0.9)).write(tf);
  Transforms().add("map", "base_link", 1, with(1, nan)).write(tf);
  Transforms().add("ma\xffp", "base_link", 1, some_pose(1)).write(tf);
  Transforms().add("map", "\xc0\xaf", 1, some_pose(1)).write(tf);
  Transforms().add("map", "", 1, some_pose(1)).write(tf);
  Transforms().add("map", std::string(300, 'a'), 1, some_pose(1)).write(tf);
  Transforms many;
  for (std::size_t i = 0; i <= limits::kTransforms; ++i) many.add("map", "base_link", 1, some_pose(1));
  many.write(tf);
  Transforms().add("a", "b", 1, some_pose(1)).add("b", "a", 1, some_pose(1)).write(tf);
  Transforms late;
  late.add("map", "base_link", 1, some_pose(1));
  tf2_msgs_msg_dds__TFMessage_ wrong = late.message();
  wrong.transforms._buffer[0].header.stamp.nanosec = 2'000'000'000;
  EXPECT_EQ(dds_write(tf, &wrong), DDS_RETCODE_OK);

  // The type's name is right, and the bytes are those of another type.
  dds_topic_descriptor_t forged = nav_msgs_msg_dds__Odometry__desc;
  forged.m_typename = tf2_msgs_msg_dds__TFMessage__desc.m_typename;
  const Ros2Peer forger(domain);
  const dds_entity_t forged_tf = forger.writer(forged, "rt/tf");
  ASSERT_TRUE(has_readers(forged_tf));
  for (const std::int32_t length : {3, 0x7fffffff, -1}) {
    nav_msgs_msg_dds__Odometry_ odometry{};
    char text[] = "x";
    odometry.header.stamp.sec = length;  // is read as the number of transforms
    odometry.header.frame_id = odometry.child_frame_id = text;
    EXPECT_EQ(dds_write(forged_tf, &odometry), DDS_RETCODE_OK);
  }
  // The topic's name is right, and the type is another one.
  const Ros2Peer stranger(domain);
  const dds_entity_t foreign = stranger.writer(sensor_msgs_msg_dds__CameraInfo__desc, "rt/tf");
  EXPECT_GT(foreign, 0);

  EXPECT_TRUE(wait_until([&] { return source->rejected().size() >= 7; }));
  EXPECT_TRUE(wait_until([&] { return source->rejected()["ros2_undecodable"] == 3; }));
  const std::map<std::string, std::uint64_t> expected = {
      {"ros2_invalid_pose", 4},  {"ros2_invalid_text", 3}, {"ros2_oversized", 2},   {"ros2_loop", 1},
      {"ros2_invalid_stamp", 1}, {"ros2_undecodable", 3},  {"ros2_foreign_type", 1}};
  EXPECT_EQ(source->rejected(), expected);
  EXPECT_EQ(source->status().malformed, 15u);
  std::vector<StampedPose> arrived;
  source->poll(arrived);
  EXPECT_TRUE(arrived.empty());
  Transforms().add("map", "base_link", 2, some_pose(2)).write(tf);
  const std::vector<StampedPose> poses = next_poses(*source);
  ASSERT_EQ(poses.size(), 1u);
  expect_equal(poses[0].frame_from_child, some_pose(2));
}

/// Processor time of this process while it waits, as a share of a core. It has threads of DDS, which do next to nothing.
double share_of_a_core_while_waiting() {
  const std::clock_t used = std::clock();
  const double begin = steady_now();
  std::this_thread::sleep_for(std::chrono::milliseconds(700));
  return double(std::clock() - used) / CLOCKS_PER_SEC / (steady_now() - begin);
}

TEST(Ros2Graph, ASourceThatWaitsUsesNoProcessorTime) {
  const LoopbackDomain domain;
  const auto chain = open_pose_source("ros2:map,base_link"), odometry = open_pose_source("ros2:/odom");
  EXPECT_LT(share_of_a_core_while_waiting(), 0.2) << "before there is a publisher";
  const Ros2Peer robot(domain);
  const dds_entity_t tf = robot.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf"),
                     odom = robot.writer(nav_msgs_msg_dds__Odometry__desc, "rt/odom");
  ASSERT_TRUE(has_readers(tf) && has_readers(odom));
  ASSERT_TRUE(is_connected(*chain) && is_connected(*odometry));
  EXPECT_LT(share_of_a_core_while_waiting(), 0.2) << "beside silent publishers";
}

TEST(Ros2Graph, SaysWhyNothingComes) {
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  const auto source = open_pose_source("ros2:map,base_link");
  const auto says = [&](const char* part) {
    const bool found = wait_until([&] { return test::contains(source->status().last_error, part); });
    return found ? testing::AssertionSuccess()
                 : testing::AssertionFailure() << "'" << source->status().last_error << "'";
  };
  const dds_entity_t unreliable = robot.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf", false);
  EXPECT_GT(unreliable, 0);
  EXPECT_TRUE(says("another quality of service (it is not reliable)"));
  const Ros2Peer other(domain);
  const dds_entity_t tf = other.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf");
  ASSERT_TRUE(has_readers(tf) && is_connected(*source));
  Transforms().add("odom", "base_link", 1, some_pose(1)).write(tf);
  EXPECT_TRUE(says("no chain leads from 'map' to 'base_link' by the 1 frame received"));
  const auto unknown = open_pose_source("ros2:/camera_info");
  const dds_entity_t info = other.writer(sensor_msgs_msg_dds__CameraInfo__desc, "rt/camera_info");
  EXPECT_GT(info, 0);
  EXPECT_TRUE(wait_until([&] {
    return test::contains(unknown->status().last_error,
                          "/camera_info is published as sensor_msgs/msg/CameraInfo, which is not read here");
  })) << unknown->status().last_error;
}

/// The bytes of a sample, without padding at the end; releases it.
std::vector<std::uint8_t> bytes_of(ddsi_serdata* data) {
  std::vector<std::uint8_t> bytes(ddsi_serdata_size(data));
  ddsi_serdata_to_ser(data, 0, bytes.size(), bytes.data());
  ddsi_serdata_unref(data);
  const std::size_t padding = bytes.size() > 4 ? bytes[3] & 3u : 0;
  bytes.resize(bytes.size() - padding);
  bytes[3] = 0;
  return bytes;
}
std::vector<std::uint8_t> next_bytes(dds_entity_t reader) {
  ddsi_serdata* data = nullptr;
  dds_sample_info_t info;
  EXPECT_TRUE(wait_until([&] { return dds_takecdr(reader, &data, 1, &info, DDS_ANY_STATE) == 1; }));
  return data == nullptr ? std::vector<std::uint8_t>() : bytes_of(data);
}

TEST(Ros2Cdr, BytesOfTransformsAreThoseOfAnIndependentEncoder) {
  const LoopbackDomain domain;
  const Ros2Peer from(domain), to(domain);
  const dds_entity_t reader = to.reader(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf");
  const dds_entity_t writer = from.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf");
  ASSERT_TRUE(has_readers(writer) && has_writer(reader));
  Pose pose;
  pose.translation << 1.5, -2.25, 1e-300;
  pose.rotation.coeffs() << 0.1, -0.7, 0.1, 0.7;
  Transforms().add("map", "odom", 12.5, pose).add("odom", "base_link", 3, pose).write(writer);
  Cdr cdr;
  cdr.number(std::uint32_t(2));
  for (const auto& [frame, child, sec, nanosec] :
       {std::tuple{"map", "odom", 12, 500'000'000u}, std::tuple{"odom", "base_link", 3, 0u}})
    cdr.number(std::int32_t(sec))
        .number(std::uint32_t(nanosec))
        .text(frame)
        .text(child)
        .numbers({1.5, -2.25, 1e-300, 0.1, -0.7, 0.1, 0.7});
  EXPECT_EQ(next_bytes(reader), cdr.bytes());
}

TEST(Ros2Publisher, CameraInfoOfALensShiftedProjectorReachesALateJoinerByteForByte) {
  const LoopbackDomain domain;
  ProjectorPublisher publisher("ros2:/robot1");
  publisher.publish_camera_info("left projector", lens_shifted_projector(), 1700000000.5);
  EXPECT_EQ(
      publisher.description(),
      "ROS 2 domain " + std::to_string(domain.number()) +
          ", network lo (127.0.0.1): publishes /robot1/left_projector/camera_info, /tf_static, /diagnostics");
  const Ros2Peer late(domain);
  const dds_entity_t reader =
      late.reader(sensor_msgs_msg_dds__CameraInfo__desc, "rt/robot1/left_projector/camera_info", true, true);
  EXPECT_EQ(next_bytes(reader), test::camera_info_bytes(1700000000, 500000000, "robot1/left projector"));
  // A sensor subscriber: best effort, volatile.
  const dds_entity_t sensor =
      late.reader(sensor_msgs_msg_dds__CameraInfo__desc, "rt/robot1/left_projector/camera_info", false);
  ASSERT_TRUE(wait_until([&] {
    dds_subscription_matched_status_t matched;
    return dds_get_subscription_matched_status(sensor, &matched) == DDS_RETCODE_OK &&
           matched.current_count == 1;
  }));
  Camera fisheye = lens_shifted_projector();
  fisheye.distortion = FisheyeDistortion{{0.1, -0.2, 0.3, -0.4}};
  ASSERT_TRUE(wait_until([&] {
    publisher.publish_camera_info("left projector", fisheye, 1700000001);
    void* samples[1] = {};
    dds_sample_info_t info;
    if (dds_take(sensor, samples, &info, 1, 1) != 1) return false;
    const auto& received = *static_cast<const sensor_msgs_msg_dds__CameraInfo_*>(samples[0]);
    EXPECT_STREQ(received.distortion_model, "equidistant");
    EXPECT_EQ(std::vector<double>(received.d._buffer, received.d._buffer + received.d._length),
              (std::vector<double>{0.1, -0.2, 0.3, -0.4}));
    dds_return_loan(sensor, samples, 1);
    return true;
  }));
  EXPECT_ERROR(publisher.publish_camera_info("\xd0\xb0", fisheye, 1), kInput, "Latin letters");
  for (const char* text : {"udp:1", "ros2:/a/", "ros2:/a,/b", "ros2:a b"})
    EXPECT_ERROR(ProjectorPublisher{text}, kInput, "e.g. ");
}

TEST(Ros2Publisher, FramesOfTheRigJoinTheChainsOfTheRobot) {
  const LoopbackDomain domain;
  ProjectorPublisher publisher("ros2:/procam");
  EXPECT_EQ(publisher.frame("rig"), "procam/rig");
  publisher.publish_frames({{"base_link", "procam/rig", {some_pose(9), Mat6::Zero()}}}, 1);
  publisher.publish_frames({{"base_link", "procam/rig", {some_pose(1), Mat6::Zero()}},
                            {"procam/rig", "procam/projector", {some_pose(2), Mat6::Zero()}}},
                           2);
  const Ros2Peer robot(domain);
  const dds_entity_t tf = robot.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf");
  const dds_entity_t joiner = robot.reader(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf_static", true, true);
  void* samples[4] = {};
  dds_sample_info_t infos[4];
  int count = 0;
  ASSERT_TRUE(wait_until([&] { return (count = dds_take(joiner, samples, infos, 4, 4)) > 0; }));
  EXPECT_EQ(count, 1);  // the newest replaces the others
  EXPECT_EQ(static_cast<const tf2_msgs_msg_dds__TFMessage_*>(samples[0])->transforms._length, 2u);
  dds_return_loan(joiner, samples, count);
  // By a source of this process, which shares its domain.
  const auto source = open_pose_source("ros2:map,procam/projector");
  ASSERT_TRUE(has_readers(tf) && is_connected(*source));
  ASSERT_TRUE(wait_until([&] { return source->status().connections >= 2; }));
  Transforms().add("map", "base_link", 5, some_pose(3)).write(tf);
  std::vector<StampedPose> poses = next_poses(*source);
  ASSERT_EQ(poses.size(), 1u);
  expect_equal(poses[0].frame_from_child, some_pose(3) * some_pose(1) * some_pose(2));
}

TEST(Ros2Publisher, MarkersReachALateJoinerByteForByte) {
  const LoopbackDomain domain;
  ProjectorPublisher publisher("ros2:/procam");
  publisher.publish_markers({test::some_markers().back()}, 1);
  publisher.publish_markers(test::some_markers(), 2.5);
  const Ros2Peer late(domain);
  const dds_entity_t reader =
      late.reader(visualization_msgs_msg_dds__MarkerArray__desc, "rt/procam/markers", true, true);
  EXPECT_EQ(next_bytes(reader), test::marker_bytes());
}

TEST(Ros2Publisher, APoseHasItsCovarianceInTheOrderOfRos) {
  const LoopbackDomain domain;
  ProjectorPublisher publisher("ros2:/procam");
  const Mat6 ros = some_ros_covariance(), left = left_covariance(ros, some_pose(4));
  publisher.publish_pose("world", {some_pose(4), left}, 1);
  // By a source of this process, and by a reader of another.
  const auto source = open_pose_source("ros2:/procam/pose");
  const Ros2Peer robot(domain);
  const dds_entity_t reader =
      robot.reader(geometry_msgs_msg_dds__PoseWithCovarianceStamped__desc, "rt/procam/pose");
  ASSERT_TRUE(is_connected(*source) && has_writer(reader));
  void* samples[1] = {};
  dds_sample_info_t info;
  ASSERT_TRUE(wait_until([&] {
    publisher.publish_pose("world", {some_pose(4), left}, 2.5);
    return dds_take(reader, samples, &info, 1, 1) == 1;
  }));
  const auto& message = *static_cast<const geometry_msgs_msg_dds__PoseWithCovarianceStamped_*>(samples[0]);
  EXPECT_EQ(message.header.stamp.sec, 2);
  for (int i = 0; i < 36; ++i)
    EXPECT_NEAR(message.pose.covariance[i], ros(i / 6, i % 6), 1e-8 * ros.cwiseAbs().maxCoeff()) << i;
  dds_return_loan(reader, samples, 1);
  const std::vector<StampedPose> poses = next_poses(*source);
  ASSERT_FALSE(poses.empty());
  expect_equal(poses.back().frame_from_child, some_pose(4));
  ASSERT_TRUE(poses.back().covariance);
  EXPECT_LT((*poses.back().covariance - left).cwiseAbs().maxCoeff(), 1e-8 * left.cwiseAbs().maxCoeff());
}

TEST(Ros2Publisher, HealthIsADiagnosticArrayByteForByte) {
  const LoopbackDomain domain;
  ProjectorPublisher publisher("ros2:");
  const Ros2Peer monitor(domain);
  const dds_entity_t reader =
      monitor.reader(diagnostic_msgs_msg_dds__DiagnosticArray__desc, "rt/diagnostics");
  const DeviceHealth health = test::some_health();
  // The publisher may know the reader later than the reader knows the publisher, and a message before that is lost.
  publisher.publish_health(health, 2.5);
  ASSERT_TRUE(has_writer(reader));
  ddsi_serdata* data = nullptr;
  dds_sample_info_t info;
  ASSERT_TRUE(wait_until([&] {
    publisher.publish_health(health, 2.5);
    return dds_takecdr(reader, &data, 1, &info, DDS_ANY_STATE) == 1;
  }));
  EXPECT_EQ(bytes_of(data), test::health_bytes());
}

}  // namespace
}  // namespace procam::dds
