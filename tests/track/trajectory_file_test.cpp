// Trajectories as other programs write them; the files in golden/ hold the same three poses in their formats.
#include "procam/track/trajectory_file.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "procam/core/base/limits.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/track/pose_source.hpp"
#include "support/expect_error.hpp"

namespace procam::track {
namespace {

std::string golden(const std::string& name) {
  return std::string(PROCAM_SOURCE_DIR) + "/tests/track/golden/" + name;
}

/// Written to a file of its own, removed at the end.
class TextFile {
 public:
  explicit TextFile(const std::string& text) : path_("/tmp/procam_trajectory_XXXXXX") {
    close(mkstemp(path_.data()));
    std::ofstream(path_) << text;
  }
  ~TextFile() { std::remove(path_.c_str()); }
  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

const Pose kFirst(so3_exp<double>(Vec3(0.3, -0.7, 1.1)), Vec3(0.878612, 2.14247, 0.947262));
const Pose kLast(so3_exp<double>(Vec3(-2.0, 0.4, 0.9)), Vec3(-0.9, 2.12, 0.953));

/// Quaternions in any order but the file's give other rotations: the poses have none that is its own mirror.
TEST(Trajectory, OfEveryFormatIsTheSame) {
  struct File {
    const char* name;
    const char* format;
    const char* frame;
    const char* child;
  };
  for (const File& file :
       {File{"tum.txt", "TUM", "map", "base"}, File{"orb_slam3_euroc.txt", "TUM", "map", "base"},
        File{"euroc.csv", "EuRoC", "map", "base"}, File{"rostopic_odom.csv", "rosbag", "odom", "base_link"},
        File{"rostopic_pose.csv", "rosbag", "map", "base"},
        File{"rostopic_tf.csv", "rosbag", "camera_init", "aft_mapped"},
        File{"bagpy_odom.csv", "rosbag", "odom", "base_link"}}) {
    SCOPED_TRACE(file.name);
    const Trajectory read = read_trajectory(golden(file.name));
    EXPECT_EQ(read.format, file.format);
    ASSERT_EQ(read.poses.size(), 3u);
    EXPECT_EQ(read.poses[0].frame, file.frame);
    EXPECT_EQ(read.poses[0].child, file.child);
    // 1e-6: the digits that the programs write. The time of the message, not that of its recording.
    EXPECT_NEAR(*read.poses[0].stamp, 1403636579.763555584, 1e-6);
    EXPECT_NEAR(*read.poses[2].stamp - *read.poses[0].stamp, 0.1, 1e-6);
    EXPECT_LT(se3_log(read.poses[0].frame_from_child * kFirst.inverse()).norm(), 3e-6);
    EXPECT_LT(se3_log(read.poses[2].frame_from_child * kLast.inverse()).norm(), 3e-6);
  }
}

TEST(Trajectory, OfKittiTakesItsTimesFromASecondFile) {
  const Trajectory read = read_trajectory(golden("kitti.txt") + "+" + golden("kitti_times.txt"));
  EXPECT_EQ(read.format, "KITTI");
  ASSERT_EQ(read.poses.size(), 3u);
  EXPECT_NEAR(*read.poses[1].stamp - *read.poses[0].stamp, 0.05, 1e-6);
  EXPECT_LT(se3_log(read.poses[2].frame_from_child * kLast.inverse()).norm(), 3e-6);
  EXPECT_ERROR(read_trajectory(golden("kitti.txt")), kInput, "kitti.txt+times.txt");
  EXPECT_ERROR(read_trajectory(golden("kitti.txt") + "+" + golden("tum.txt")), kInput, "8 numbers where 1");
  EXPECT_ERROR(read_trajectory(golden("tum.txt") + "+" + golden("kitti_times.txt")), kInput,
               "for KITTI poses only");
}

/// ROS has it about the child's origin, translation first.
TEST(Trajectory, CovarianceOfOdometryIsOfTheLeftIncrement) {
  const StampedPose pose = read_trajectory(golden("rostopic_odom.csv")).poses[0];
  ASSERT_TRUE(pose.covariance);
  const Mat6& c = *pose.covariance;
  EXPECT_NEAR(c(0, 0), 0.001, 1e-12);
  // Variance of the origin's x by the rotation about y and z, beside its own: t_z^2 var_y + t_y^2 var_z.
  const Vec3 t = kFirst.translation;
  EXPECT_NEAR(c(3, 3), 0.01 + t.z() * t.z() * 0.002 + t.y() * t.y() * 0.003, 1e-9);
}

/// rostopic echo -p writes nanoseconds, and a simulation's clock begins at zero.
TEST(Trajectory, OfASimulationHasSmallTimes) {
  const TextFile file(
      "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.pose.position.x,field.pose.position.y,"
      "field.pose.position.z,field.pose.orientation.x,field.pose.orientation.y,field.pose.orientation.z,"
      "field.pose.orientation.w\n"
      "12500000000,5,12250000000,odom,1.5,-2.25,0.75,0,0,0.6,0.8\n"
      "12600000000,6,12350000000,odom,1.6,-2.35,0.75,0,0,0.6,0.8\n");
  const Trajectory read = read_trajectory(file.path());
  ASSERT_EQ(read.poses.size(), 2u);
  EXPECT_NEAR(*read.poses[0].stamp, 12.25, 1e-9);
  EXPECT_NEAR(*read.poses[1].stamp, 12.35, 1e-9);
}

TEST(Trajectory, IsASourceOfPoses) {
  const auto source = open_pose_source("log:" + golden("euroc.csv") + "@0");
  std::vector<StampedPose> arrived;
  source->poll(arrived);
  ASSERT_EQ(arrived.size(), 3u);
  EXPECT_LT(se3_log(arrived[2].frame_from_child * kLast.inverse()).norm(), 3e-6);
  const auto kitti = open_pose_source("log:" + golden("kitti.txt") + "+" + golden("kitti_times.txt") + "@0");
  kitti->poll(arrived);
  EXPECT_EQ(arrived.size(), 3u);
}

TEST(Trajectory, RefusesWhatItCannotRead) {
  const auto expect_input = [](const std::string& text, const std::string& words) {
    const TextFile file(text);
    SCOPED_TRACE(text);
    EXPECT_ERROR(read_trajectory(file.path()), kInput, words);
  };
  // The order of a quaternion is not guessed.
  expect_input("1403715274,0.1,0.2,0.3,0.5,-0.5,0.5,0.5\n", "line 1: its numbers stand between commas");
  expect_input("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0\n", "line 2: it has 7 numbers where 8");
  expect_input("1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n", "line 2: its time is not after that of the line before");
  expect_input("1 0 0 0 0 0 0 2\n", "line 1: the quaternion's length is not 1");
  expect_input("1 0 0 nan 0 0 0 1\n", "line 1: 'nan' is not a finite number");
  expect_input("", "it is empty");
  expect_input("1 2 3 4 5\n", "line 1: it has 5 numbers");
  expect_input("#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m]\n1,2,3,4\n", "no orientation");
  expect_input("%time,field.data\n1,2\n", "no position");
  expect_input("%time,field.poses0.position.x,field.poses1.position.x\n1,2,3\n", "several poses");
  const TextFile comment("# nothing\n");
  EXPECT_ERROR(read_trajectory(comment.path()), kNotEnoughData, "it holds no pose");
  EXPECT_ERROR(read_trajectory("/nowhere/at/all.txt"), kIo, "all.txt");
  const TextFile endless("1 0 0 0 0 0 0 1\n");
  std::filesystem::resize_file(endless.path(), 16 + limits::kLogLineBytes + 1);
  EXPECT_ERROR(read_trajectory(endless.path()), kInput, "line 2: it is longer than 64 MiB");
}

}  // namespace
}  // namespace procam::track
