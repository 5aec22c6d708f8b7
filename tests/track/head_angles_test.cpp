/// Angles of a pan-tilt head as messages, as a log and as poses.
#include "procam/track/head_angles.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "procam/core/base/error.hpp"
#include "support/expect_error.hpp"

namespace procam::track {
namespace {

const PlacedHead kHead{
    {0.04, 1.6}, Pose(so3_exp(Vec3(0.02, -0.01, 0.7)), Vec3(1.2, -0.4, 0.9)), "room", "tilt"};

TEST(HeadAngles, BecomePosesOfTheTiltingPart) {
  const ParsedAngles parsed = parse_angles(
      "{\"stamp\":12.5,\"sequence\":7,\"pan_deg\":30,\"tilt_deg\":-12.5}\n{\"pan_deg\":1,\"tilt_deg\":2}");
  ASSERT_EQ(parsed.angles.size(), 2u);
  EXPECT_EQ(parsed.malformed, 0u);
  const StampedPose pose = pose_of(parsed.angles[0], kHead);
  EXPECT_EQ(pose.stamp, 12.5);
  EXPECT_EQ(pose.sequence, 7u);
  EXPECT_EQ(pose.frame, "room");
  // Along the pan axis by hand: Rz(30) puts the tilt axis's foot 40 mm off the pan axis.
  const Vec3 in_head = kHead.world_from_head.inverse() * pose.frame_from_child.translation;
  EXPECT_NEAR(in_head.x(), 0.04 * std::cos(30 * kDegree), 1e-12);
  EXPECT_NEAR(in_head.y(), 0.04 * std::sin(30 * kDegree), 1e-12);
  EXPECT_NEAR(in_head.z(), 0, 1e-12);
  // The tilt axis itself does not move with the tilt.
  StampedAngles tilted = parsed.angles[0];
  tilted.tilt += 1;
  EXPECT_NEAR((pose_of(tilted, kHead).frame_from_child.rotate(Vec3::UnitZ()) -
               pose.frame_from_child.rotate(Vec3::UnitZ()))
                  .norm(),
              0, 1e-12);
  EXPECT_FALSE(parsed.angles[1].stamp);
}

TEST(HeadAngles, ThatAreNoneAreCountedWithTheirReason) {
  for (const char* bad :
       {"{\"pan_deg\":1}", "[1,2]", "{\"pan_deg\":1,\"tilt_deg\":\"2\"}",
        "{\"pan_deg\":1e300,\"tilt_deg\":0}", "{\"pan_deg\":1,\"tilt_deg\":2,\"pan_deg\":3}",
        "{\"pan_deg\":1,\"tilt_deg\":{\"a\":2}}", "7", "{\"pan\":1,\"tilt_deg\":2}",
        "{\"pan_deg\":1,\"tilt_deg\":2,\"sequence\":1.5}"}) {
    const ParsedAngles parsed = parse_angles(bad);
    EXPECT_TRUE(parsed.angles.empty()) << bad;
    EXPECT_EQ(parsed.malformed, 1u) << bad;
    EXPECT_FALSE(parsed.why.empty()) << bad;
  }
}

TEST(HeadAngles, AreReadBackFromTheirLogAndAsASource) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "procam_head_angles_test.log";
  std::vector<StampedAngles> written(3);
  for (std::size_t i = 0; i < 3; ++i) {
    written[i].stamp = 10 + 0.5 * double(i);
    written[i].arrival = 100 + 0.5 * double(i);
    written[i].pan = 0.1 * double(i);
    written[i].tilt = -0.2;
  }
  write_angle_log(file, written);
  const std::vector<StampedAngles> read = read_angle_log(file);
  ASSERT_EQ(read.size(), 3u);
  EXPECT_NEAR(read[2].pan, 0.2, 1e-9);
  EXPECT_EQ(read[2].arrival, 101);
  const auto source = open_head_source("log:" + file.string() + "@0", kHead);
  std::vector<StampedPose> poses;
  source->poll(poses);
  ASSERT_EQ(poses.size(), 3u);
  EXPECT_LT(
      (poses[1].frame_from_child.matrix() - pose_of(written[1], kHead).frame_from_child.matrix()).norm(),
      1e-8);
  // Moved into another world, as the poses of an arm are.
  const Pose world(so3_exp(Vec3(0, 0, 1)), Vec3(1, 2, 3));
  const auto moved = moved_source(open_head_source("log:" + file.string() + "@0", kHead), world);
  std::vector<StampedPose> there;
  moved->poll(there);
  ASSERT_EQ(there.size(), 3u);
  EXPECT_LT((there[0].frame_from_child.matrix() - (world * poses[0].frame_from_child).matrix()).norm(),
            1e-12);
  std::ofstream(file) << "{\"format\":\"procam-pose-log\",\"version\":1}\n";
  EXPECT_ERROR(read_angle_log(file), kInput, "its format is \"procam-pose-log\", not \"procam-angle-log\"");
  std::ofstream(file) << "{\"version\": 1, \"format\": \"procam-angle-log\"}\n"
                         "{\"stamp\": 2.5, \"pan_deg\": 12.5, \"tilt_deg\": -3.0}\n";
  ASSERT_EQ(read_angle_log(file).size(), 1u);
  EXPECT_NEAR(read_angle_log(file)[0].pan, 12.5 * kDegree, 1e-12);
  std::filesystem::remove(file);
  EXPECT_THROW(open_head_source("osc:9000", kHead), Error);
}

}  // namespace
}  // namespace procam::track
