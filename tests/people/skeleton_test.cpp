// Skeletons from bytes: real logs, and what strangers send.
#include "procam/people/skeleton_reader.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <random>
#include <sstream>

#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/people/interaction.hpp"
#include "skeleton_csv.hpp"
#include "support/expect_error.hpp"
#include "support/test_data.hpp"
#include "vmc.hpp"

namespace procam::people {
namespace {

/// The person a little right of the camera, left hand raised; lopsided on purpose.
SkeletonFrame example() {
  SkeletonFrame frame;
  frame.stamp = 1700000000.25;
  frame.frame = "kinect \"A\"";
  Skeleton person;
  person.id = 41;
  person[Joint::kHead] = SeenJoint<Vec3>{Vec3(0.31, -0.52, 2.25), 0.75};
  person[Joint::kLeftHand] = SeenJoint<Vec3>{Vec3(0.77, -0.63, 1.875), 0.5};
  person[Joint::kRightFoot] = SeenJoint<Vec3>{Vec3(0.22, 1.14, 2.375), 1};
  frame.people = {person, Skeleton()};
  return frame;
}

TEST(SkeletonLine, ReadsBackWhatItWrites) {
  const ParsedSkeletons parsed =
      parse_skeletons(to_json_line(example()) + "\n" + to_json_line(SkeletonFrame()));
  ASSERT_EQ(parsed.malformed, 0u) << parsed.why;
  ASSERT_EQ(parsed.frames.size(), 2u);
  const SkeletonFrame &read = parsed.frames[0], wrote = example();
  EXPECT_EQ(read.stamp, wrote.stamp);
  EXPECT_EQ(read.frame, wrote.frame);
  ASSERT_EQ(read.people.size(), 2u);
  EXPECT_EQ(read.people[0].id, 41);
  EXPECT_FALSE(read.people[1].id);
  for (std::size_t j = 0; j < kJointCount; ++j) {
    const auto &a = read.people[0].joints[j], &b = wrote.people[0].joints[j];
    ASSERT_EQ(a.has_value(), b.has_value()) << to_string(Joint(j));
    if (!a) continue;
    EXPECT_LT((a->position - b->position).norm(), 1e-8);
    EXPECT_EQ(a->confidence, b->confidence);
  }
  // Nobody is news as well.
  EXPECT_TRUE(parsed.frames[1].people.empty());
  for (std::size_t j = 0; j < kJointCount; ++j) EXPECT_EQ(joint_of(to_string(Joint(j))), Joint(j));
}

TEST(SkeletonLine, AbsentJointsAreNeverZero) {
  const ParsedSkeletons parsed = parse_skeletons(
      R"({"people":[{"joints":{"left_hand":null,"right_hand":[0,0,0,0],"head":[0.1,0.2,2]}}]})");
  ASSERT_EQ(parsed.frames.size(), 1u) << parsed.why;
  const Skeleton& person = parsed.frames[0].people[0];
  EXPECT_FALSE(person[Joint::kLeftHand]);
  EXPECT_FALSE(person[Joint::kRightHand]);
  EXPECT_TRUE(person[Joint::kHead]);
}

TEST(SkeletonLine, RefusesNonsenseWithWords) {
  const auto why = [](const std::string& line) {
    const ParsedSkeletons parsed = parse_skeletons(line);
    EXPECT_TRUE(parsed.frames.empty()) << line;
    EXPECT_EQ(parsed.malformed, 1u) << line;
    return parsed.why;
  };
  const auto joint = [](const std::string& value) {
    return R"({"people":[{"joints":{"head":)" + value + "}}]}";
  };
  EXPECT_NE(why(joint("[0,0,1e30]")).find("beyond 20 m"), std::string::npos);
  EXPECT_NE(why(joint("[0,0,1e999]")), "");
  EXPECT_NE(why(joint("[0,0,NaN]")), "");
  EXPECT_NE(why(joint("[0,0]")), "");
  EXPECT_NE(why(joint("[0,0,1,1,1]")), "");
  EXPECT_NE(why(joint("[0,0,1,-0.5]")), "");
  EXPECT_NE(why(joint("[0,0,\"1\"]")), "");
  EXPECT_NE(why(R"({"people":[{"joints":{"left_wing":[0,0,1]}}]})").find("unknown"), std::string::npos);
  EXPECT_NE(why(R"({"people":{}})"), "");
  EXPECT_NE(why(R"({"stamp":1e300,"people":[]})"), "");
  EXPECT_NE(why("{\"people\":" + std::string(5000, '[') + "}").find("deep"), std::string::npos);
  const auto crowd = [](std::size_t count) {
    std::string line = R"({"people":[)";
    for (std::size_t i = 0; i < count; ++i)
      line += std::string(i == 0 ? "" : ",") + R"({"joints":{"head":[0,0,2]}})";
    return line + "]}";
  };
  EXPECT_EQ(parse_skeletons(crowd(limits::kPeople)).frames.size(), 1u);
  EXPECT_NE(why(crowd(limits::kPeople + 1)).find("more than 16 people"), std::string::npos);
  EXPECT_NE(why(crowd(500)).find("more than 16 people"), std::string::npos);
  const auto padded = [](std::size_t size) {
    const std::string line = R"({"people":[]})";
    return line.substr(0, 1) + std::string(size - line.size(), ' ') + line.substr(1);
  };
  EXPECT_EQ(parse_skeletons(padded(limits::kSkeletonLineBytes)).frames.size(), 1u);
  EXPECT_NE(why(padded(limits::kSkeletonLineBytes + 1)), "");
  EXPECT_NE(why(R"({"frame":"a\u001b[2J","people":[]})").find("not UTF-8, has control characters"),
            std::string::npos);
}

/// Bytes flipped, cut and doubled: no crash, no NaN, nothing beyond sanity gets through.
TEST(SkeletonReaders, SurviveDamage) {
  std::mt19937 random(11);
  const auto number = [&](std::size_t below) { return std::size_t(random()) % below; };
  std::string openpose = R"({"people":[{"pose_keypoints_2d":[)", world = R"({"worldLandmarks":[[)";
  for (int i = 0; i < 75; ++i) openpose += std::string(i == 0 ? "" : ",") + "12.5";
  for (int i = 0; i < 33; ++i)
    world += std::string(i == 0 ? "" : ",") + R"({"x":0.1,"y":-0.2,"z":0.3,"visibility":0.9})";
  std::string azure = R"({"frames":[{"timestamp_usec":5,"bodies":[{"body_id":1,"joint_positions":[)";
  for (int i = 0; i < 32; ++i) azure += std::string(i == 0 ? "" : ",") + "[100,-200,2000]";
  const std::vector<std::string> texts = {
      to_json_line(example()), openpose + "]}]}", world + "]]}", azure + "]}]}]}",
      "t_s,head_x_m,head_y_m,head_z_m,head_ok\n0,0.1,0.2,2,1\n0.1,nan,0.2,2,1\n0.2,0.1,0.2,2,0\n"};
  for (int round = 0; round < 4000; ++round) {
    std::string text = texts[number(texts.size())];
    for (std::size_t hits = 1 + number(4); hits > 0; --hits) {
      const std::size_t at = number(text.size());
      switch (number(3)) {
        case 0:
          text[at] = char(random());
          break;
        case 1:
          text.resize(at + 1);
          break;
        default:
          text.insert(at, text.substr(at / 2, number(40)));
      }
    }
    std::vector<SkeletonFrame> frames = parse_skeletons(text).frames;
    for (SkeletonFrame& frame : parse_azure_kinect(text).frames) frames.push_back(std::move(frame));
    try {
      for (SkeletonFrame& frame : parse_skeleton_csv(text).frames) frames.push_back(std::move(frame));
    } catch (const Error&) {
    }
    for (const SkeletonFrame& frame : frames) ASSERT_EQ(why_refused(frame), nullptr) << text;
    for (const PixelSkeleton& person : parse_openpose(text).people)
      for (const auto& seen : person.joints) ASSERT_TRUE(!seen || seen->position.allFinite());
    for (const HipCentredPerson& person : parse_mediapipe(text).people)
      for (const auto& seen : person.about_hips.joints) ASSERT_TRUE(!seen || seen->position.allFinite());
  }
}

TEST(SkeletonCsv, TellsAbsentFromWrong) {
  const std::string header =
      "t_s,left_hand_x_m,left_hand_y_m,left_hand_z_m,left_hand_ok,comment,handRight_x_m,"
      "handRight_y_m,handRight_z_m\n";
  const ParsedSkeletons parsed = parse_skeleton_csv(header +
                                                    "0.0,1,2,3,1,hello,-1,-2,4\n"
                                                    "0.1,1,2,3,0,stale,nan,NaN,4\n"  // nobody
                                                    "0.2,,,,1,empty,-1,-2,4\r\n"
                                                    "0.3,1e30,2,3,1,far,-1,-2,4\n"
                                                    "0.4,1,x,3,1,text,-1,-2,4\n"
                                                    "0.5,1,2\n"
                                                    ",1,2,3,1,no time,-1,-2,4\n");
  EXPECT_EQ(parsed.malformed, 4u);
  ASSERT_EQ(parsed.frames.size(), 3u);
  EXPECT_EQ(*parsed.frames[0].people[0].position(Joint::kLeftHand), Vec3(1, 2, 3));
  EXPECT_EQ(*parsed.frames[0].people[0].position(Joint::kRightHand), Vec3(-1, -2, 4));
  EXPECT_TRUE(parsed.frames[1].people.empty());
  EXPECT_FALSE(parsed.frames[2].people[0][Joint::kLeftHand]);
  EXPECT_TRUE(parsed.frames[2].people[0][Joint::kRightHand]);
  EXPECT_ERROR(parse_skeleton_csv("x,y\n1,2\n"), kInput, "t_s");
  EXPECT_ERROR(read_skeleton_log("no/such/file.csv"), kIo, "no/such/file.csv");
}

// --- other makers' sets ---

TEST(JointSets, LeftStaysThePersonsOwn) {
  // Facing the sensor a person's left is on its right: x > 0 in the optical frame.
  std::vector<ForeignJoint> azure(32), kinect(25);
  azure[8] = {Vec3(400, -100, 2000), 3};    // HAND_LEFT, mm
  azure[15] = {Vec3(-400, -100, 2000), 1};  // HAND_RIGHT
  azure[26] = {Vec3(0, 0, 0), 0};           // HEAD, not seen
  const Skeleton a = from_joint_set(JointSet::kAzureKinect, azure);
  EXPECT_EQ(*a.position(Joint::kLeftHand), Vec3(0.4, -0.1, 2));
  EXPECT_EQ(a[Joint::kLeftHand]->confidence, 1);
  EXPECT_LT(a[Joint::kRightHand]->confidence, 0.5);
  EXPECT_FALSE(a[Joint::kHead]);
  kinect[7] = {Vec3(-0.4, 0.1, 2), 2};  // HandLeft: x to the sensor's left, y up
  const Skeleton k = from_joint_set(JointSet::kKinectV2, kinect);
  EXPECT_EQ(*k.position(Joint::kLeftHand), Vec3(0.4, -0.1, 2));
  EXPECT_FALSE(k[Joint::kPelvis]);
  EXPECT_THROW(from_joint_set(JointSet::kKinectV2, azure), std::invalid_argument);
}

// --- VMC, written as its specification says: OSC 1.0 messages, big-endian, texts padded to four bytes

std::string osc_padded(std::string text) {
  text.append(4 - text.size() % 4, '\0');
  return text;
}
std::string big_endian(std::uint32_t value) {
  return {char(value >> 24), char(value >> 16 & 255), char(value >> 8 & 255), char(value & 255)};
}
std::string vmc_pose(const std::string& address, const std::string& name, const std::array<float, 7>& pose) {
  std::string bytes = osc_padded(address) + osc_padded(",sfffffff") + osc_padded(name);
  for (const float value : pose) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    bytes += big_endian(bits);
  }
  return bytes;
}
std::string bone(const std::string& name, float x, float y, float z, const std::array<float, 4>& turn) {
  return vmc_pose("/VMC/Ext/Bone/Pos", name, {x, y, z, turn[0], turn[1], turn[2], turn[3]});
}
std::string bundle(const std::vector<std::string>& messages) {
  std::string bytes = std::string("#bundle\0", 8) + big_endian(0) + big_endian(1);
  for (const std::string& message : messages) bytes += big_endian(std::uint32_t(message.size())) + message;
  return bytes;
}
constexpr std::array<float, 4> kStraight = {0, 0, 0, 1};
/// Unity's Euler(0, 0, 90), which takes right to up.
constexpr std::array<float, 4> kUpwards = {0, 0, 0.70710678f, 0.70710678f};

/// An avatar that stands 2 m ahead and looks along z, whose own left is at -x; without UpperChest and Neck.
/// The left arm is lifted at the shoulder by `arm`.
std::vector<std::string> avatar(const std::array<float, 4>& arm) {
  return {vmc_pose("/VMC/Ext/Root/Pos", "root", {0.5f, 0.1f, 2, 0, 0, 0, 1}),
          bone("Hips", 0, 0.9f, 0, kStraight),
          bone("Spine", 0, 0.1f, 0, kStraight),
          bone("Chest", 0, 0.2f, 0.02f, kStraight),
          bone("Head", 0, 0.3f, 0, kStraight),
          bone("LeftUpperArm", -0.2f, 0.15f, 0, arm),
          bone("LeftLowerArm", -0.3f, 0, 0, kStraight),
          bone("LeftHand", -0.25f, 0, 0, kStraight),
          bone("LeftMiddleProximal", -0.1f, 0, 0, kStraight),
          bone("RightUpperLeg", 0.1f, -0.05f, 0, kStraight)};
}

TEST(Vmc, BonesAreChainedIntoTheOpticalFrame) {
  VmcReader reader;
  EXPECT_TRUE(reader.parse(bundle(avatar(kStraight))).frames.empty()) << "nothing tells that it is whole";
  // Its second frame comes with the first one's end; from then on each comes at once.
  EXPECT_EQ(reader.parse(bundle(avatar(kStraight))).frames.size(), 2u);
  const ParsedSkeletons parsed = reader.parse(bundle(avatar(kUpwards)));
  EXPECT_EQ(parsed.malformed, 0u) << parsed.why;
  ASSERT_EQ(parsed.frames.size(), 1u);
  ASSERT_EQ(parsed.frames[0].people.size(), 1u);
  const Skeleton& person = parsed.frames[0].people[0];
  const auto expect_at = [&](Joint joint, const Vec3& where) {
    ASSERT_TRUE(person[joint]) << to_string(joint);
    EXPECT_LT((person[joint]->position - where).norm(), 1e-6) << to_string(joint);
  };
  expect_at(Joint::kPelvis, Vec3(0.5, -1.0, 2));
  expect_at(Joint::kChest, Vec3(0.5, -1.3, 2.02));
  expect_at(Joint::kHead, Vec3(0.5, -1.69, 2.02));
  expect_at(Joint::kLeftShoulder, Vec3(0.3, -1.45, 2.02));
  // Turned from right to up, what lies to the left hangs down: 0.3, then 0.25, then half of 0.1.
  expect_at(Joint::kLeftElbow, Vec3(0.3, -1.15, 2.02));
  expect_at(Joint::kLeftWrist, Vec3(0.3, -0.9, 2.02));
  expect_at(Joint::kLeftHand, Vec3(0.3, -0.85, 2.02));
  expect_at(Joint::kRightHip, Vec3(0.6, -0.95, 2));
  EXPECT_FALSE(person[Joint::kRightWrist]);
  EXPECT_FALSE(person[Joint::kNeck]);
}

TEST(Vmc, FramesComeInAnyNumberOfDatagrams) {
  VmcReader reader;
  reader.parse(bundle(avatar(kStraight)));
  reader.parse(bundle(avatar(kStraight)));
  std::size_t frames = 0;
  for (int round = 0; round < 3; ++round)
    for (const std::string& message : avatar(kUpwards)) frames += reader.parse(message).frames.size();
  EXPECT_EQ(frames, 3u);
  // Faces and times are nobody's joints; an avatar that is gone is news.
  EXPECT_EQ(reader.parse(osc_padded("/VMC/Ext/Blend/Apply") + osc_padded(",")).malformed, 0u);
  const ParsedSkeletons gone = reader.parse(osc_padded("/VMC/Ext/OK") + osc_padded(",i") + big_endian(0));
  ASSERT_EQ(gone.frames.size(), 1u);
  EXPECT_TRUE(gone.frames[0].people.empty());
}

TEST(Vmc, RefusesWhatIsNoPose) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const std::string& bytes :
       {bone("Hips", nan, 0, 0, kStraight), bone("Hips", 1e30f, 0, 0, kStraight),
        bone("Hips", 0, 0, 0, {0, 0, 0, 0}), bone("Hips", 0, 0, 0, kStraight).substr(0, 50),
        std::string("junk"), std::string(),
        osc_padded("/tracking/trackers/1") + osc_padded(",f") + big_endian(0),
        osc_padded("/VMC/Ext/Bone/Pos") + osc_padded(",sf") + osc_padded("Hips") + big_endian(0),
        bundle({bone("Hips", 0, 1, 0, kStraight)}).substr(0, 60),
        bundle({bundle({bundle({bundle({bundle({})})})})})}) {
    VmcReader reader;
    const ParsedSkeletons parsed = reader.parse(bytes);
    EXPECT_EQ(parsed.malformed, 1u);
    EXPECT_NE(parsed.why, "");
    EXPECT_TRUE(parsed.frames.empty());
  }
  // Rotations alone, all positions zero.
  VmcReader reader;
  const std::vector<std::string> flat = {bone("Hips", 0, 0, 0, kUpwards), bone("Spine", 0, 0, 0, kUpwards),
                                         bone("Head", 0, 0, 0, kStraight)};
  reader.parse(bundle(flat));
  const ParsedSkeletons parsed = reader.parse(bundle(flat));
  EXPECT_TRUE(parsed.frames.empty());
  EXPECT_NE(parsed.why.find("rotations alone"), std::string::npos) << parsed.why;
  // Any damage, and whole frames after it.
  std::mt19937 random(3);
  const std::string whole = bundle(avatar(kUpwards));
  for (int i = 0; i < 3000; ++i) {
    std::string damaged = whole;
    for (int k = 0; k < 4; ++k) damaged[random() % damaged.size()] = char(random());
    damaged.resize(random() % (damaged.size() + 1));
    for (const SkeletonFrame& frame : reader.parse(damaged).frames) EXPECT_EQ(why_refused(frame), nullptr);
  }
  reader.parse(whole);
  EXPECT_GE(reader.parse(whole).frames.size(), 1u);
}

TEST(MediaPipe, IsAnchoredByTheFloor) {
  std::string text = R"({"worldLandmarks":[[)";
  std::string picture = R"(]],"landmarks":[[)";
  for (int i = 0; i < 33; ++i) {
    // Left ankle 0.81 m, left toes 0.9 m below the hips, the right foot raised.
    const double y = i == 27 ? 0.81 : i == 31 ? 0.9 : i == 28 || i == 32 ? 0.5 : -0.1;
    const std::string separator = i == 0 ? "" : ",";
    text += separator + R"({"x":0.1,"y":)" + std::to_string(y) + R"(,"z":0.05,"visibility":0.9})";
    picture += separator + R"({"x":)" + (i == 23 ? "0.5" : "0.4") + R"(,"y":0.6,"z":0})";
  }
  const HipCentredPeople parsed = parse_mediapipe(text + picture + "]]}");
  ASSERT_EQ(parsed.people.size(), 1u) << parsed.why;
  EXPECT_LT((*parsed.people[0].hips_in_picture - Vec2(0.45, 0.6)).norm(), 1e-12);
  // A camera 1.2 m above the floor, tilted down by 10 degrees; hips truly at `hips`.
  const double tilt = 10 * kDegree;
  const Plane floor{Vec3(0, -std::cos(tilt), -std::sin(tilt)), 1.2};
  const double lowest = floor.normal.dot(Vec3(0.1, 0.9, 0.05));  // the left toes
  const Vec3 bearing = Vec3(0.2, 0.12, 1).normalized();
  const auto person = anchored_on_floor(parsed.people[0].about_hips, bearing, floor);
  ASSERT_TRUE(person);
  EXPECT_NEAR(floor.signed_distance(*person->position(Joint::kLeftFoot)), 0, 1e-9);
  EXPECT_GT(floor.signed_distance(*person->position(Joint::kRightFoot)), 0.3);
  const Vec3 hips = *person->position(Joint::kLeftFoot) - Vec3(0.1, 0.9, 0.05);
  EXPECT_LT(hips.cross(bearing).norm(), 1e-9);
  EXPECT_NEAR(hips.norm(), -(1.2 + lowest) / floor.normal.dot(bearing), 1e-9);
  EXPECT_FALSE(anchored_on_floor(parsed.people[0].about_hips, Vec3(0, -0.5, 1).normalized(), floor));
  EXPECT_FALSE(anchored_on_floor(Skeleton(), bearing, floor));
}

}  // namespace
}  // namespace procam::people
