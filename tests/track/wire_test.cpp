// Poses as bytes: what is written is read back, and nothing that can be sent does harm.
#include "procam/track/wire.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>

#include "../support/lopsided.hpp"
#include "procam/core/base/detail/plain_text.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/core/geometry/covariance.hpp"
#include "procam/track/pose_log.hpp"
#include "procam/track/pose_source.hpp"
#include "support/expect_error.hpp"
#include "wire_parsers.hpp"

namespace procam::track {
namespace {

Mat6 lopsided_covariance() {
  Mat6 factor;
  for (Eigen::Index i = 0; i < 36; ++i) factor(i / 6, i % 6) = 0.01 * double((i * 7) % 11) - 0.03;
  return factor * factor.transpose() + 1e-4 * Mat6::Identity();
}

StampedPose full_message() {
  StampedPose message;
  message.stamp = 1700000000.123457;
  message.frame = "map \"north\"";
  message.child = "b\xc3\xa4se";
  message.frame_from_child = test::lopsided_pose();
  message.covariance = lopsided_covariance();
  message.twist = (Vec6() << 0.1, -0.2, 0.3, 0.4, -0.5, 0.6).finished();
  message.angular_rate = Vec3(0.11, -0.21, 0.31);
  message.sequence = 4294967295u;
  return message;
}
StampedPose bare_message() {
  StampedPose message;
  message.frame = "map";
  message.child = "base";
  message.frame_from_child = test::other_lopsided_pose();
  return message;
}

void expect_same_pose(const Pose& a, const Pose& b, double tolerance) {
  EXPECT_LT(se3_log(a.inverse() * b).norm(), tolerance);
}
void expect_same(const StampedPose& a, const StampedPose& b) {
  EXPECT_EQ(a.stamp, b.stamp);
  EXPECT_EQ(a.frame, b.frame);
  EXPECT_EQ(a.child, b.child);
  EXPECT_EQ(a.sequence, b.sequence);
  expect_same_pose(a.frame_from_child, b.frame_from_child, 1e-15);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.twist, b.twist);
  EXPECT_EQ(a.angular_rate, b.angular_rate);
}

TEST(PoseWire, JsonAndBinaryAreReadBackAsTheyWere) {
  for (const StampedPose& message : {full_message(), bare_message()}) {
    for (const std::string& bytes : {to_json_line(message), to_binary(message)}) {
      const Parsed parsed = parse_poses(bytes);
      ASSERT_EQ(parsed.poses.size(), 1u) << parsed.why;
      EXPECT_EQ(parsed.malformed, 0u);
      expect_same(parsed.poses[0], message);
    }
  }
  EXPECT_EQ(to_binary(bare_message()).size(), 78u + 4 + 7);
}

TEST(PoseWire, ADatagramMayHoldSeveral) {
  const std::string both = "\n" + to_json_line(full_message()) + to_binary(bare_message()) + "\r\n  " +
                           to_json_line(bare_message());
  const Parsed parsed = parse_poses(both.substr(0, both.size() - 1));  // the last newline may be missing
  EXPECT_EQ(parsed.malformed, 0u) << parsed.why;
  ASSERT_EQ(parsed.poses.size(), 3u);
  expect_same(parsed.poses[1], bare_message());
}

TEST(PoseWire, ANearlyUnitQuaternionIsNormalised) {
  const Parsed parsed =
      parse_poses(R"({"frame":"map","child":"base","position":[1,2,3],"quaternion":[0,0,0.706,0.706]})");
  ASSERT_EQ(parsed.poses.size(), 1u) << parsed.why;
  EXPECT_NEAR(parsed.poses[0].frame_from_child.rotation.norm(), 1, 1e-15);
  EXPECT_FALSE(parsed.poses[0].stamp);
}

/// A replay draws from the same doubles as the run.
TEST(PoseWire, WhatWasReadAndWrittenIsReadAsTheSameNumbers) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 200; ++i) {
    StampedPose message = bare_message();
    message.frame_from_child = test::random_pose(random);
    const std::string once = to_json_line(parse_poses(to_json_line(message)).poses.at(0));
    EXPECT_EQ(to_json_line(parse_poses(once).poses.at(0)), once);
    message.frame_from_child.rotation.coeffs() *= 1.005;  // accepted, and scaled
    message.stamp = -0.0;
    const std::string scaled = to_binary(parse_poses(to_json_line(message)).poses.at(0));
    EXPECT_EQ(to_binary(parse_poses(scaled).poses.at(0)), scaled);
  }
}

TEST(PoseWire, WhatIsNoMessageIsRefusedWithItsReason) {
  const std::string good = R"("frame":"map","child":"base","position":[1,2,3],"quaternion":[0,0,0,1])";
  std::string zeros = "0";
  for (int i = 1; i < 36; ++i) zeros += ",0";
  std::string negative = zeros;
  negative.replace(0, 1, "-1");
  std::string askew = zeros;
  askew.replace(2, 1, "1");
  const std::pair<std::string, std::string> cases[] = {
      {"hello", "neither"},
      {"{" + good, "not JSON"},
      {"{" + good + "} {", "not JSON"},
      {"{" + good + R"(,"stamp":NaN})", "not JSON"},
      {"{" + good + R"(,"stamp":1e999})", "not JSON"},
      {"{" + good + R"(,"stamp":1e13})", "stamp"},
      {"{" + good + R"(,"stamp":null})", "null"},
      {"{" + good + R"(,"stamp":"1"})", "text"},
      {"{" + good + R"(,"stamp":[1]})", "array"},
      {"{" + good + R"(,"stamp":{}})", "object"},
      {"{" + good + R"(,"stamp":1,"stamp":2})", "twice"},
      {"{" + good + R"(,"covarience":[1]})", "a key that"},
      {"{" + good + R"(,"arrival":1})", "a key that"},
      {"{" + good + R"(,"sequence":-1})", "sequence"},
      {"{" + good + R"(,"sequence":1.5})", "sequence"},
      {"{" + good + R"(,"twist":[1,2,3]})", "short"},
      {"{" + good + R"(,"twist":[1,2,3,4,5,6,7]})", "long"},
      {"{" + good + R"(,"twist":[1,2,3,4,5,[6]]})", "array"},
      {"{" + good + R"(,"covariance":[)" + negative + "]}", "negative"},
      {"{" + good + R"(,"covariance":[)" + askew + "]}", "symmetric"},
      {R"({"frame":"map","child":"base","position":[1,2,3],"quaternion":[0,0,0,1.1]})", "length is not 1"},
      {R"({"frame":"map","child":"base","position":[1,2,3],"quaternion":[0,0,0,0]})", "length is not 1"},
      {R"({"frame":"map","child":"base","position":[1e7,2,3],"quaternion":[0,0,0,1]})", "position"},
      {R"({"frame":"map","position":[1,2,3],"quaternion":[0,0,0,1]})", "missing"},
      {R"([1,2])", "neither"},
      {std::string(5000, '{'), "not JSON"},
      {"{" + good + R"(,"frame":")" + std::string(300, 'x') + "\"}", "twice"},
      {"{\"frame\":\"" + std::string(300, 'x') + "\"}", "longer than 255"},
      {"{" + std::string(9000, ' ') + good + "}", "8192"},
  };
  for (const auto& [line, why] : cases) {
    const Parsed parsed = parse_poses(line);
    EXPECT_EQ(parsed.malformed, 1u) << line.substr(0, 100);
    EXPECT_TRUE(parsed.poses.empty()) << line.substr(0, 100);
    EXPECT_NE(parsed.why.find(why), std::string::npos) << line.substr(0, 200) << "\n" << parsed.why;
  }
}

TEST(PoseWire, EveryBitOfABinaryMessageCounts) {
  const std::string good = to_binary(full_message());
  for (std::size_t i = 0; i < 8 * good.size(); ++i) {
    std::string flipped = good;
    flipped[i / 8] = char(flipped[i / 8] ^ (1 << (i % 8)));
    const Parsed parsed = parse_poses(flipped);
    EXPECT_TRUE(parsed.poses.empty()) << i;
    EXPECT_EQ(parsed.malformed, 1u) << i;
  }
  for (std::size_t size = 1; size < good.size(); ++size)
    EXPECT_EQ(parse_poses(good.substr(0, size)).malformed, 1u) << size;
}

TEST(PoseWire, ADatagramOfWrongLinesIsNotReadToItsEnd) {
  std::string lines;
  for (int i = 0; i < 30000; ++i) lines += "{\n";
  EXPECT_EQ(parse_poses(lines).malformed, 16u);
}

TEST(PoseWire, AStreamMayBeCutAnywhere) {
  const std::string garbage = std::string("\x80\x90{no\xff\n", 7);
  const std::string stream = to_json_line(full_message()) + to_binary(bare_message()) + garbage +
                             to_binary(full_message()) + "\n" + to_json_line(bare_message());
  for (std::size_t first = 0; first <= stream.size(); first += 3) {
    StreamParser parser;
    std::size_t poses = 0, malformed = 0;
    for (const auto& part : {stream.substr(0, first), stream.substr(first, 5),
                             stream.substr(std::min(first + 5, stream.size()))}) {
      const Parsed parsed = parser.parse(part);
      poses += parsed.poses.size();
      malformed += parsed.malformed;
    }
    EXPECT_EQ(poses, 4u) << first;
    EXPECT_EQ(malformed, 1u) << first;
  }
  StreamParser parser;  // no newline ever: given up, and not kept
  std::size_t malformed = 0;
  for (int i = 0; i < 100; ++i) malformed += parser.parse(std::string(1000, '{')).malformed;
  EXPECT_EQ(malformed, 1u);
  EXPECT_EQ(parser.parse("\n" + to_json_line(bare_message())).poses.size(), 1u);
}

TEST(PoseWire, OscIsReadBackAndInBundles) {
  const StampedPose message = full_message();
  StampedPose plain = bare_message();
  Parsed parsed = parse_osc(to_osc(plain));
  ASSERT_EQ(parsed.poses.size(), 1u) << parsed.why;
  EXPECT_EQ(parsed.poses[0].frame, "map");
  EXPECT_EQ(parsed.poses[0].child, "base");
  EXPECT_FALSE(parsed.poses[0].stamp);
  expect_same_pose(parsed.poses[0].frame_from_child, plain.frame_from_child, 1e-15);

  // A bundle of one, 2023-11-14T22:13:20.5Z in NTP's seconds; floats, as most programs send.
  const std::string bundle =
      std::string("#bundle\0", 8) + std::string("\xe8\xfe\x6f\x80\x80\0\0\0", 8) +
      std::string("\0\0\0\x34", 4) + std::string("/cart/pose\0\0,fffffff\0\0\0\0", 24) +
      std::string("\x3f\x80\0\0\x40\0\0\0\xbf\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x3f\x80\0\0", 28);
  parsed = parse_osc(bundle);
  ASSERT_EQ(parsed.poses.size(), 1u) << parsed.why;
  EXPECT_EQ(parsed.poses[0].child, "cart");
  EXPECT_EQ(parsed.poses[0].stamp, 1700000000.5);
  EXPECT_EQ(parsed.poses[0].frame_from_child.translation, Vec3(1, 2, -0.5));

  EXPECT_NE(parse_osc(std::string("/fader/1\0\0\0\0,f\0\0\0\0\0\0", 20)).why.find("/pose"),
            std::string::npos);
  std::string nested = to_osc(plain);
  for (int i = 0; i < 6; ++i) {
    const auto size = char(std::uint8_t(nested.size()));
    nested = std::string("#bundle\0\0\0\0\0\0\0\0\1\0\0\0", 19) + size + nested;
  }
  EXPECT_NE(parse_osc(nested).why.find("deep"), std::string::npos);
}

// A name that is no text could be neither recorded nor replayed: refused at the boundary, by every form.
TEST(PoseWire, NamesAreUtf8) {
  const auto named = [](const std::string& name) {
    StampedPose message = bare_message();
    message.child = name;
    return message;
  };
  const std::string good = "Wägen ☃";
  EXPECT_EQ(parse_osc(to_osc(named(good))).poses.size(), 1u);
  EXPECT_EQ(parse_poses(to_binary(named(good))).poses.size(), 1u);
  EXPECT_EQ(parse_poses(to_json_line(named(good))).poses.size(), 1u);
  for (const char* bad : {"\xff", "cart\xc3", "\xc0\x80", "\xed\xa0\x80", "\xf5\x80\x80\x80", "a\x1b[2J"}) {
    for (const Parsed& parsed : {parse_osc(to_osc(named(bad))), parse_poses(to_binary(named(bad)))}) {
      EXPECT_TRUE(parsed.poses.empty()) << bad;
      EXPECT_EQ(parsed.malformed, 1u);
      EXPECT_NE(parsed.why.find("a frame's name is not UTF-8"), std::string::npos) << parsed.why;
    }
  }
  const Parsed status = parse_rosbridge("{\"op\":\"status\",\"level\":\"error\",\"msg\":\"a\\u001b[2J" +
                                        std::string(300, 'x') + "\"}");
  EXPECT_NE(status.why.find("says: a?[2Jx"), std::string::npos) << status.why;
  // Cut after 200 bytes, within a character.
  std::string long_text;
  for (int i = 0; i < 100; ++i) long_text += "☃";
  const Parsed cut = parse_rosbridge("{\"op\":\"status\",\"level\":\"error\",\"msg\":\"" + long_text + "\"}");
  EXPECT_TRUE(procam::internal::is_plain_text(cut.why)) << cut.why;
}

// A message as long as the limit is read, and one byte more is not.
TEST(PoseWire, TheLimitOfAMessageIsInBytes) {
  const auto line = [](std::size_t size) {
    std::string text = to_json_line(bare_message());
    text.insert(1, size + 1 - text.size(), ' ');  // without the newline
    return text;
  };
  EXPECT_EQ(parse_poses(line(limits::kMessageBytes)).poses.size(), 1u);
  const Parsed longer = parse_poses(line(limits::kMessageBytes + 1));
  EXPECT_TRUE(longer.poses.empty());
  EXPECT_EQ(longer.why, "a line is longer than 8192 bytes");
}

TEST(PoseWire, PosiStageNetIsReadBack) {
  StampedPose message = bare_message();
  message.stamp = 12.345678;
  message.child = "tracker 513";
  const Parsed parsed = parse_psn(to_psn(message));
  ASSERT_EQ(parsed.poses.size(), 1u) << parsed.why;
  EXPECT_EQ(parsed.poses[0].child, "tracker 513");
  EXPECT_NEAR(*parsed.poses[0].stamp, *message.stamp, 1e-9);
  expect_same_pose(parsed.poses[0].frame_from_child, message.frame_from_child, 1e-6);  // single precision

  // Bytes as the standard has them: chunk 0x6755 with subchunks, header (2.3, one packet), tracker 1 at (1,
  // 2, -0.5), turned by half a radian about y; a speed besides.
  const std::string packet(
      "\x55\x67\x44\x80"
      "\x00\x00\x0c\x00\x40\x42\x0f\x00\x00\x00\x00\x00\x02\x03\x07\x01"
      "\x01\x00\x30\x80"
      "\x01\x00\x2c\x80"
      "\x00\x00\x0c\x00\x00\x00\x80\x3f\x00\x00\x00\x40\x00\x00\x00\xbf"
      "\x02\x00\x0c\x00\x00\x00\x00\x00\x00\x00\x00\x3f\x00\x00\x00\x00"
      "\x01\x00\x08\x00\x00\x00\x00\x00\x00\x00\x00\x00",
      72);
  const Parsed standard = parse_psn(packet);
  ASSERT_EQ(standard.poses.size(), 1u) << standard.why;
  EXPECT_EQ(standard.malformed, 0u);
  EXPECT_EQ(standard.poses[0].stamp, 1.0);
  EXPECT_EQ(standard.poses[0].child, "tracker 1");
  expect_same_pose(standard.poses[0].frame_from_child, Pose(so3_exp(Vec3(0, 0.5, 0)), Vec3(1, 2, -0.5)),
                   1e-6);
  EXPECT_EQ(parse_psn(std::string("\x56\x67\x00\x80", 4)).malformed, 0u);  // names: not waited for

  // The same tracker without its orientation: no pose that only looks complete.
  const std::string without_orientation(
      "\x55\x67\x34\x80"
      "\x00\x00\x0c\x00\x40\x42\x0f\x00\x00\x00\x00\x00\x02\x03\x07\x01"
      "\x01\x00\x20\x80"
      "\x01\x00\x1c\x80"
      "\x00\x00\x0c\x00\x00\x00\x80\x3f\x00\x00\x00\x40\x00\x00\x00\xbf"
      "\x01\x00\x08\x00\x00\x00\x00\x00\x00\x00\x00\x00",
      56);
  const Parsed bare = parse_psn(without_orientation);
  EXPECT_TRUE(bare.poses.empty());
  EXPECT_EQ(bare.malformed, 1u);
  EXPECT_NE(bare.why.find("a position without an orientation"), std::string::npos) << bare.why;
}

// At the limit, and one above.
TEST(PoseWire, NamesBundlesAndListsHaveLimits) {
  StampedPose message = bare_message();
  message.child = std::string(limits::kFrameNameBytes, 'x');
  EXPECT_EQ(parse_poses(to_json_line(message)).poses.size(), 1u);
  EXPECT_EQ(parse_osc(to_osc(message)).poses.size(), 1u);
  message.child += 'x';
  EXPECT_EQ(parse_poses(to_json_line(message)).malformed, 1u);
  EXPECT_EQ(parse_osc(to_osc(message)).malformed, 1u);

  std::string nested = to_osc(bare_message());
  const auto wrap = [&nested] {
    const auto size = char(std::uint8_t(nested.size()));
    nested = std::string("#bundle\0\0\0\0\0\0\0\0\1\0\0\0", 19) + size + nested;
  };
  for (int depth = 0; depth < limits::kOscDepth; ++depth) wrap();
  EXPECT_EQ(parse_osc(nested).poses.size(), 1u);
  wrap();
  EXPECT_EQ(parse_osc(nested).malformed, 1u);

  const auto transforms = [](std::size_t count) {
    std::string text = R"({"op":"publish","topic":"/tf","msg":{"transforms":[)";
    for (std::size_t i = 0; i < count; ++i)
      text +=
          std::string(i == 0 ? "" : ",") +
          R"({"header":{"stamp":{"sec":5,"nanosec":0},"frame_id":"map"},"child_frame_id":"base","transform":{)"
          R"("translation":{"x":1,"y":2,"z":3},"rotation":{"x":0,"y":0,"z":0,"w":1}}})";
    return text + "]}}";
  };
  EXPECT_EQ(parse_rosbridge(transforms(limits::kTransforms)).poses.size(), limits::kTransforms);
  EXPECT_TRUE(parse_rosbridge(transforms(limits::kTransforms + 1)).poses.empty());
}

const char* const kOdometry = R"({"op":"publish","topic":"/odom","msg":{
  "header":{"stamp":{"sec":1700000000,"nanosec":250000000},"frame_id":"odom"},"child_frame_id":"base_link",
  "pose":{"pose":{"position":{"x":1,"y":2,"z":0.5},"orientation":{"x":0,"y":0,"z":0.6,"w":0.8}},
          "covariance":[0.01,0,0,0,0,0, 0,0.02,0,0,0,0, 0,0,0.03,0,0,0, 0,0,0,0.04,0,0, 0,0,0,0,0.05,0, 0,0,0,0,0,0.06]},
  "twist":{"twist":{"linear":{"x":0.5,"y":0.1,"z":0},"angular":{"x":0,"y":0.2,"z":0.3}},"covariance":[]}}})";
const char* const kTransforms = R"({"op":"publish","topic":"/tf","msg":{"transforms":[
  {"header":{"stamp":{"secs":5,"nsecs":500000000},"frame_id":"/map"},"child_frame_id":"odom",
   "transform":{"translation":{"x":1,"y":2,"z":3},"rotation":{"x":0,"y":0,"z":0,"w":1}}},
  {"header":{"stamp":{"secs":5,"nsecs":500000000},"frame_id":"odom"},"child_frame_id":"base_link",
   "transform":{"translation":{"x":4,"y":null,"z":6},"rotation":{"x":0,"y":0,"z":0,"w":1}}}]}})";

TEST(PoseWire, RosWithoutAStampIsNotStamped) {
  const std::string stamp = R"("stamp":{"sec":1700000000,"nanosec":250000000},)";
  const auto with = [&](const std::string& other) {
    std::string text = kOdometry;
    text.replace(text.find(stamp), stamp.size(), other);
    return parse_rosbridge(text);
  };
  for (const char* none : {"", R"("stamp":{"sec":0,"nanosec":0},)"}) {
    const Parsed parsed = with(none);
    ASSERT_EQ(parsed.poses.size(), 1u) << none << parsed.why;
    EXPECT_EQ(parsed.poses[0].stamp, std::nullopt) << none;
  }
  EXPECT_EQ(with(R"("stamp":{"sec":"soon"},)").malformed, 1u);
}

TEST(PoseWire, RosIsConvertedToTheHousesOrder) {
  const Parsed parsed = parse_rosbridge(kOdometry);
  ASSERT_EQ(parsed.poses.size(), 1u) << parsed.why;
  const StampedPose& odometry = parsed.poses[0];
  EXPECT_EQ(odometry.frame, "odom");
  EXPECT_EQ(odometry.child, "base_link");
  EXPECT_EQ(odometry.stamp, 1700000000.25);
  EXPECT_EQ(*odometry.twist, (Vec6() << 0, 0.2, 0.3, 0.5, 0.1, 0).finished());
  EXPECT_EQ(odometry.frame_from_child.translation, Vec3(1, 2, 0.5));
  // The robot's own position has ROS's variances, whatever the left increment's look like.
  const Mat3 position = point_covariance({odometry.frame_from_child, *odometry.covariance}, Vec3::Zero());
  EXPECT_LT((position - Mat3(Vec3(0.01, 0.02, 0.03).asDiagonal())).norm(), 1e-12);
  EXPECT_EQ(odometry.covariance->diagonal().head<3>(), Vec3(0.04, 0.05, 0.06));

  const Parsed transforms = parse_rosbridge(kTransforms);
  ASSERT_EQ(transforms.poses.size(), 1u);
  EXPECT_EQ(transforms.malformed, 1u);  // null is what rosbridge makes of NaN
  EXPECT_EQ(transforms.poses[0].frame, "map");
  EXPECT_EQ(transforms.poses[0].stamp, 5.5);
  EXPECT_NE(
      parse_rosbridge(R"({"op":"status","level":"error","msg":"no such topic"})").why.find("no such topic"),
      std::string::npos);
  EXPECT_EQ(parse_rosbridge(std::string(100000, '[')).malformed, 1u);
  EXPECT_EQ(parse_rosbridge("{\"op\":" + std::string(100000, '[')).malformed, 1u);
}

void expect_sound(const Parsed& parsed) {
  for (const StampedPose& message : parsed.poses) {
    EXPECT_TRUE(message.frame_from_child.is_finite());
    EXPECT_NEAR(message.frame_from_child.rotation.norm(), 1, 1e-9);
    EXPECT_LE(message.frame_from_child.translation.cwiseAbs().maxCoeff(), kFarthest);
    if (message.covariance) {
      EXPECT_TRUE(message.covariance->allFinite());
    }
    if (message.twist) {
      EXPECT_TRUE(message.twist->allFinite());
    }
  }
}

TEST(PoseWire, NoBytesDoHarm) {
  // 40000 pieces from a seed: valid messages of every form with bytes changed, cut, doubled and joined, and
  // noise. What this asserts is above all the sanitizers' business.
  std::mt19937_64 random(20);
  const std::vector<std::string> seeds = {to_json_line(full_message()),
                                          to_binary(full_message()),
                                          to_osc(full_message()),
                                          to_psn(bare_message()),
                                          kOdometry,
                                          kTransforms};
  StreamParser stream;
  for (int i = 0; i < 40000; ++i) {
    std::string bytes = seeds[random() % seeds.size()];
    for (std::uint64_t changes = random() % 4 + 1; changes > 0; --changes) {
      const std::size_t at = bytes.empty() ? 0 : random() % bytes.size();
      switch (random() % 6) {
        case 0:
          if (!bytes.empty()) bytes[at] = char(random());
          break;
        case 1:
          bytes.resize(at);
          break;
        case 2:
          bytes.insert(at, bytes.substr(random() % (bytes.size() + 1), random() % 64));
          break;
        case 3:
          bytes.erase(at, random() % 16);
          break;
        case 4: {
          static const char* const tokens[] = {"1e308", "-0",      "null",   "[[[[", "}",
                                               "\"",    "\\u0000", "1e-400", "\n",   ","};
          bytes.insert(at, tokens[random() % 10]);
          break;
        }
        default:
          bytes = std::string(random() % 300, '\0');
          for (char& c : bytes) c = char(random());
      }
    }
    expect_sound(parse_poses(bytes));
    expect_sound(parse_osc(bytes));
    expect_sound(parse_psn(bytes));
    expect_sound(parse_rosbridge(bytes));
    expect_sound(stream.parse(bytes));
  }
}

TEST(PoseLog, IsReadBackAndReplayed) {
  const auto path = std::filesystem::path(testing::TempDir()) / "procam_pose_log_test.log";
  {
    PoseLogWriter log(path);
    for (int k = 0; k < 5; ++k) {
      StampedPose message = k % 2 ? full_message() : bare_message();
      message.arrival = 812.25 + k / 3.0;
      log.write(message);
    }
  }
  const std::vector<StampedPose> messages = read_pose_log(path);
  ASSERT_EQ(messages.size(), 5u);
  EXPECT_EQ(messages[4].arrival, 812.25 + 4 / 3.0);
  expect_same(messages[3], full_message());

  std::vector<StampedPose> arrived;
  const auto at_once = open_pose_source("log:" + path.string() + "@0");
  at_once->poll(arrived);
  ASSERT_EQ(arrived.size(), 5u);
  EXPECT_EQ(arrived[1].arrival, messages[1].arrival);
  EXPECT_FALSE(at_once->status().connected);
  at_once->poll(arrived);
  EXPECT_TRUE(arrived.empty());

  const auto in_time = open_pose_source("log:" + path.string() + "@1");
  in_time->poll(arrived);
  EXPECT_EQ(arrived.size(), 1u);
  EXPECT_NEAR(arrived[0].arrival, steady_now(), 1);

  {
    std::ofstream(path, std::ios::app) << "{\"arrival\":9";  // the program ended while it wrote
  }
  EXPECT_EQ(read_pose_log(path).size(), 5u);
  { std::ofstream(path, std::ios::app) << "\n"; }
  EXPECT_THROW(read_pose_log(path), Error);
  EXPECT_THROW(read_pose_log("/nowhere/run.log"), Error);
  std::filesystem::remove(path);
}

/// As json.dumps of Python writes it, and as other programs order it.
TEST(PoseLog, HeadersOfOtherProgramsAreRead) {
  const auto path = std::filesystem::path(testing::TempDir()) / "procam_pose_log_header_test.log";
  const auto write = [&](const char* header) {
    std::ofstream(path) << header << "\n{\"arrival\": 9, " << to_json_line(full_message()).substr(1);
  };
  for (const char* header : {"{\"format\": \"procam-pose-log\", \"version\": 1}",
                             "{\"version\":1,\"format\":\"procam-pose-log\"}\r",
                             "  { \"note\": [1], \"version\": 1.0, \"format\" : \"procam-pose-log\" } "}) {
    write(header);
    ASSERT_EQ(read_pose_log(path).size(), 1u) << header;
    expect_same(read_pose_log(path)[0], full_message());
  }
  const std::pair<const char*, const char*> refused[] = {
      {"{\"format\": \"procam-pose-log\", \"version\": 2}", "its version is not 1"},
      {"{\"format\": \"procam-pose-log\", \"version\": \"1\"}", "its version is not 1"},
      {"{\"format\": \"procam-pose-log\"}", "has no \"version\""},
      {"{\"format\": \"procam-angle-log\", \"version\": 1}",
       "its format is \"procam-angle-log\", not \"procam-pose-log\""},
      {"{\"version\": 1}", "has no \"format\""},
      {"[1]", "not a JSON object"},
      {"{\"format\": \"procam-pose-log\", \"version\": 1", "not a JSON object"}};
  for (const auto& [header, why] : refused) {
    write(header);
    EXPECT_ERROR(read_pose_log(path), kInput, why);
  }
  write(("{\"format\":\"procam-pose-log\",\"version\":1,\"deep\":" + std::string(6000, '[') + "}").c_str());
  EXPECT_ERROR(read_pose_log(path), kInput, "not a JSON object");
  std::filesystem::remove(path);
}

// It is not read to its end: memory stays bounded.
TEST(PoseLog, AnEndlessLineIsAnError) {
  const auto path = std::filesystem::path(testing::TempDir()) / "procam_endless_pose_log_test.log";
  { PoseLogWriter(path).write(bare_message()); }
  const auto size = std::filesystem::file_size(path);
  std::filesystem::resize_file(path, size + limits::kLogLineBytes);
  EXPECT_EQ(read_pose_log(path).size(), 1u) << "a last line that was cut";
  std::filesystem::resize_file(path, size + limits::kLogLineBytes + 1);
  EXPECT_ERROR(read_pose_log(path), kInput, "line 3: it is longer than 64 MiB");
  std::filesystem::resize_file(path, 0);
  EXPECT_ERROR(read_pose_log(path), kInput, "it is empty");
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace procam::track
