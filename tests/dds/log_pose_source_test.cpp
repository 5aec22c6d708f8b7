// Poses from logs of ROS 2, end to end: bytes of an encoder of the tests, in files as other programs write them.
#include <gtest/gtest.h>

#ifdef PROCAM_HAVE_SQLITE3
#include "db3_file.hpp"
#endif
#include "graph_values.hpp"
#include "log_files.hpp"
#include "procam/dds/pose_source.hpp"
#include "support/expect_error.hpp"

namespace procam::dds {
namespace {

using test::Cdr;
using test::expect_equal;
using test::kLogStart;
using test::left_covariance;
using test::log_folder;
using test::McapFile;
using test::next_poses;
using test::put;
using test::some_pose;
using test::some_ros_covariance;
using test::text_of;
using test::transforms;
using test::write_file;
using track::StampedPose;

const char* const kTf = "tf2_msgs/msg/TFMessage";

std::string bytes(const Cdr& cdr) {
  return text_of(cdr.bytes());
}

std::string odometry(double k, bool big_endian = false) {
  Cdr cdr(big_endian);
  put(cdr, 1700000000 + int(k), 250000000, "odom").text("chassis");
  put(cdr, some_pose(k));
  const Mat6 covariance = some_ros_covariance();
  for (int i = 0; i < 36; ++i) cdr.number(covariance(i / 6, i % 6));
  cdr.numbers({0.5, -0.1, 0.02, 0.01, 0.03, -0.4});
  for (int i = 0; i < 36; ++i) cdr.number(0.0);
  return bytes(cdr);
}

std::vector<StampedPose> all_of(const std::string& text) {
  std::vector<StampedPose> poses;
  open_pose_source(text)->poll(poses);
  return poses;
}

/// lamp in base_link is static, base_link in map moves.
std::string robot() {
  McapFile file;
  file.channel(1, "/tf", kTf).channel(2, "/tf_static", kTf).channel(3, "/odom", "nav_msgs/msg/Odometry");
  file.message(2, kLogStart, bytes(transforms(0, 0, "base_link", "lamp", some_pose(5))));
  for (int k = 0; k < 4; ++k) {
    file.message(1, kLogStart + std::uint64_t(k) * 100'000'000,
                 bytes(transforms(1700000000, unsigned(k) * 100000000, "map", "base_link", some_pose(k))));
    file.message(3, kLogStart + std::uint64_t(k) * 100'000'000 + 1000, odometry(k));
  }
  return file.chunk("").closed();
}

TEST(LogPoses, AChainOfFramesIsFollowed) {
  const std::string path = (log_folder() / "run.mcap").string();
  write_file(path, robot());
  const std::vector<StampedPose> lamp = all_of("log:" + path + "+map,lamp@0");
  ASSERT_EQ(lamp.size(), 4u);
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(lamp[k].frame + " " + lamp[k].child, "map lamp");
    expect_equal(lamp[k].frame_from_child, some_pose(k) * some_pose(5));
    EXPECT_NEAR(*lamp[k].stamp, 1.7e9 + 0.1 * k, 1e-6);
    EXPECT_NEAR(lamp[k].arrival, 1.7e9 + 0.1 * k, 1e-6) << "all at once: with the times of then";
  }
  // Without a choice: base_link in map.
  const std::vector<StampedPose> base = all_of("log:" + path + "@0");
  ASSERT_EQ(base.size(), 4u);
  expect_equal(base[3].frame_from_child, some_pose(3));
}

/// By REP 105 a chain has odometry where a frame is named "odom".
TEST(LogPoses, AChainWithOdometryStatesTheTwist) {
  McapFile file;
  file.channel(1, "/tf", kTf).channel(2, "/tf_static", kTf);
  file.message(2, kLogStart, bytes(transforms(1700000000, 0, "map", "odom", some_pose(2))));
  const Vec6 way = (Vec6() << 0, 0.01, 0.03, 0.05, -0.02, 0).finished();  // in 0.1 s
  Pose at = some_pose(1);
  for (unsigned k = 0; k < 6; ++k, at = (at * se3_exp(way)).normalized())
    file.message(1, kLogStart + std::uint64_t(k) * 100'000'000,
                 bytes(transforms(1700000000, k * 100000000, "odom", "base_link", at)));
  const std::string path = (log_folder() / "drive.mcap").string();
  write_file(path, file.chunk("").closed());
  const std::vector<StampedPose> poses = all_of("log:" + path + "+map,base_link@0");
  ASSERT_EQ(poses.size(), 6u);
  EXPECT_FALSE(poses[1].twist);
  ASSERT_TRUE(poses[5].twist);
  EXPECT_LT((*poses[5].twist - way / 0.1).norm(), 1e-4);
  // The localised pose of the log without the frame "odom" has none.
  for (const StampedPose& pose : all_of("log:" + path + "+odom,map@0")) EXPECT_FALSE(pose.twist);
}

TEST(LogPoses, ATopicIsReadWithItsCovarianceAndTwist) {
  const std::string path = (log_folder() / "run.mcap").string();
  write_file(path, robot());
  const std::vector<StampedPose> poses = all_of("log:" + path + "+/odom@0");
  ASSERT_EQ(poses.size(), 4u);
  EXPECT_EQ(poses[2].frame + " " + poses[2].child, "odom chassis");
  EXPECT_EQ(*poses[2].stamp, 1700000002.25);
  expect_equal(poses[2].frame_from_child, some_pose(2));
  ASSERT_TRUE(poses[2].covariance && poses[2].twist);
  const Mat6 expected = left_covariance(some_ros_covariance(), some_pose(2));
  EXPECT_LT((*poses[2].covariance - expected).cwiseAbs().maxCoeff(), 1e-8 * expected.cwiseAbs().maxCoeff());
  EXPECT_EQ(*poses[2].twist, (Vec6() << 0.01, 0.03, -0.4, 0.5, -0.1, 0.02).finished());
}

/// Machines of the other byte order, and poses that name no child.
TEST(LogPoses, BothByteOrdersAreRead) {
  const std::string path = (log_folder() / "run.mcap").string();
  Cdr stamped(true);
  put(put(stamped, 7, 500000000, "/world"), some_pose(9));
  McapFile file;
  file.channel(1, "/odom", "nav_msgs/msg/Odometry").message(1, kLogStart, odometry(1, true));
  file.channel(2, "/vicon", "geometry_msgs/msg/PoseStamped").message(2, kLogStart, bytes(stamped));
  write_file(path, file.closed(false));
  const std::vector<StampedPose> poses = all_of("log:" + path + "+/odom@0");
  ASSERT_EQ(poses.size(), 1u);
  expect_equal(poses[0].frame_from_child, some_pose(1));
  EXPECT_EQ(poses[0].child, "chassis");
  const std::vector<StampedPose> vicon = all_of("log:" + path + "+/vicon@0");
  ASSERT_EQ(vicon.size(), 1u);
  EXPECT_EQ(vicon[0].frame + " " + vicon[0].child, "world base_link");
  EXPECT_EQ(*vicon[0].stamp, 7.5);
}

TEST(LogPoses, ALogIsPlayedInItsTimeOrFaster) {
  const std::string path = (log_folder() / "run.mcap").string();
  McapFile file;
  file.channel(1, "/odom", "nav_msgs/msg/Odometry").channel(2, "/start", "std_msgs/msg/String");
  file.message(2, kLogStart, "");  // the log begins before the first pose
  for (int k = 1; k <= 3; ++k) file.message(1, kLogStart + std::uint64_t(k) * 1'000'000'000, odometry(k));
  write_file(path, file.closed());
  const double begin = steady_now();
  const auto source = open_pose_source("log:" + path + "@10");
  EXPECT_TRUE(source->status().connected);
  std::vector<StampedPose> now;
  source->poll(now);
  EXPECT_TRUE(now.empty() || steady_now() > begin + 0.1);
  const std::vector<StampedPose> poses = next_poses(*source, 3);
  ASSERT_EQ(poses.size(), 3u);
  EXPECT_NEAR(poses[0].arrival, begin + 0.1, 0.09);
  EXPECT_NEAR(poses[2].arrival - poses[0].arrival, 0.2, 1e-6);
  EXPECT_GE(steady_now(), begin + 0.3 - 1e-6) << "none is given before it is due";
  EXPECT_TRUE(test::wait_until([&] { return !source->status().connected; }));
  // A second source of the log plays together with the first.
  const auto other = open_pose_source("log:" + path + "@10");
  const std::vector<StampedPose> same = next_poses(*other, 3);
  ASSERT_EQ(same.size(), 3u);
  EXPECT_EQ(same[0].arrival, poses[0].arrival);
}

TEST(LogPoses, WhatIsNoPoseIsCountedByItsCause) {
  const std::string path = (log_folder() / "run.mcap").string();
  McapFile file;
  file.channel(1, "/odom", "nav_msgs/msg/Odometry");
  const std::string good = odometry(1);
  file.message(1, kLogStart, good);
  for (std::size_t length : {0, 3, 4, 50, 200}) file.message(1, kLogStart + 1, good.substr(0, length));
  std::string wrong = good;
  wrong[1] = 7;  // XCDR2
  file.message(1, kLogStart + 2, wrong);
  wrong = good;
  wrong[4 + 8] = 0x7f;  // the length of the frame's name
  wrong[4 + 8 + 2] = 0x7f;
  file.message(1, kLogStart + 3, wrong);
  file.message(1, kLogStart + 4, good);
  write_file(path, file.closed());
  const auto source = open_pose_source("log:" + path + "@0");
  std::vector<StampedPose> poses;
  source->poll(poses);
  EXPECT_EQ(poses.size(), 2u);
  EXPECT_EQ(source->rejected(), (std::map<std::string, std::uint64_t>{{"ros2_undecodable", 7}}));
  EXPECT_EQ(source->status().malformed, 7u);
}

TEST(LogPoses, ALogWithoutSuchPosesTellsWhatItHolds) {
  const std::string path = (log_folder() / "run.mcap").string();
  write_file(path, robot());
  EXPECT_ERROR(open_pose_source("log:" + path + "+/pose"), kInput, "it holds /tf (tf2_msgs/msg/TFMessage)");
  EXPECT_ERROR(open_pose_source("log:" + path + "+map"), kInput, "'map' is one frame of two");
  McapFile two;
  two.channel(1, "/a", "nav_msgs/msg/Odometry").channel(2, "/b", "nav_msgs/msg/Odometry");
  write_file(path, two.message(1, kLogStart, odometry(1)).closed());
  EXPECT_ERROR(open_pose_source("log:" + path), kInput, "/a (nav_msgs/msg/Odometry), /b");
  McapFile ros1;
  ros1.channel(1, "/odom", "nav_msgs/Odometry", "ros1");
  write_file(path, ros1.message(1, kLogStart, "x").closed());
  EXPECT_ERROR(open_pose_source("log:" + path), kInput, "give a log with /tf or with a topic of poses");
  // Logs of procam and trajectories are opened as before.
  const std::string text = (log_folder() / "run.txt").string();
  write_file(text, "1700000000 1 2 3 0 0 0 1\n");
  EXPECT_EQ(all_of("log:" + text + "@0").size(), 1u);
}

/// By the name they are logs, so their error is a log's and not that of a text with numbers.
TEST(LogPoses, ADamagedLogIsCalledDamaged) {
  for (const char* const name : {"junk.mcap", "junk.db3"}) {
    const std::filesystem::path path = test::log_folder() / name;
    test::write_file(path, "\x01\x02 3 numbers 4");
    EXPECT_ERROR(open_pose_source("log:" + path.string()), kInput, "it is damaged, or another format");
  }
  const std::filesystem::path begun = test::log_folder() / "begun.mcap";
  test::write_file(begun, test::kMcapMagic + std::string(100, 'x'));
  EXPECT_ERROR(open_pose_source("log:" + begun.string()), kInput, "it names no topic");
}

TEST(LogPoses, AKilledRecordersFileIsPlayedWithANotice) {
  const std::string path = (log_folder() / "run.mcap").string();
  McapFile file;
  file.channel(1, "/odom", "nav_msgs/msg/Odometry")
      .message(1, kLogStart, odometry(1))
      .message(1, kLogStart, odometry(2));
  const std::string whole = file.unclosed();
  write_file(path, whole.substr(0, whole.size() - 10));
  const auto source = open_pose_source("log:" + path + "@0");
  std::vector<StampedPose> poses;
  source->poll(poses);
  EXPECT_EQ(poses.size(), 1u);
  EXPECT_NE(source->description().find("it is read as far as it goes"), std::string::npos)
      << source->description();
}

#ifdef PROCAM_HAVE_SQLITE3
TEST(LogPoses, AFolderOfRosbag2IsOneLog) {
  const std::filesystem::path folder = log_folder() / "bag";
  std::filesystem::create_directories(folder);
  {
    test::Db3File first(folder / "bag_0.db3"), second(folder / "bag_1.db3");
    first.topic(1, "/odom", "nav_msgs/msg/Odometry").message(1, (long long)(kLogStart), odometry(1));
    second.topic(4, "/odom", "nav_msgs/msg/Odometry").message(4, (long long)(kLogStart) + 1000, odometry(2));
  }
  const std::vector<StampedPose> poses = all_of("log:" + folder.string() + "/@0");
  ASSERT_EQ(poses.size(), 2u);
  expect_equal(poses[1].frame_from_child, some_pose(2));
}
#endif

}  // namespace
}  // namespace procam::dds
