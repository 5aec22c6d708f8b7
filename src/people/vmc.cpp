#include "vmc.hpp"

#include <cmath>

#include "procam/core/base/limits.hpp"
#include "procam/track/detail/wire_bytes.hpp"

namespace procam::people {
namespace {

struct VmcBone {
  const char* name;
  int parent;  ///< place in the list; -1: the root
};
// Unity's HumanBodyBones, as far as joints are made of them; a parent stands before its children.
constexpr std::array<VmcBone, VmcReader::kBones> kVmcBones = {{{"Hips", -1},
                                                               {"Spine", 0},
                                                               {"Chest", 1},
                                                               {"UpperChest", 2},
                                                               {"Neck", 3},
                                                               {"Head", 4},
                                                               {"LeftEye", 5},
                                                               {"RightEye", 5},
                                                               {"LeftShoulder", 3},
                                                               {"RightShoulder", 3},
                                                               {"LeftUpperArm", 8},
                                                               {"RightUpperArm", 9},
                                                               {"LeftLowerArm", 10},
                                                               {"RightLowerArm", 11},
                                                               {"LeftHand", 12},
                                                               {"RightHand", 13},
                                                               {"LeftMiddleProximal", 14},
                                                               {"RightMiddleProximal", 15},
                                                               {"LeftUpperLeg", 0},
                                                               {"RightUpperLeg", 0},
                                                               {"LeftLowerLeg", 18},
                                                               {"RightLowerLeg", 19},
                                                               {"LeftFoot", 20},
                                                               {"RightFoot", 21},
                                                               {"LeftToes", 22},
                                                               {"RightToes", 23}}};
enum VmcPlace : std::size_t { kVmcHead = 5, kVmcLeftHand = 14, kVmcLeftMiddle = 16 };

/// Joints that are where a bone begins.
constexpr std::pair<std::size_t, Joint> kVmcJoints[] = {
    {0, Joint::kPelvis},        {1, Joint::kNavel},          {3, Joint::kChest},
    {4, Joint::kNeck},          {6, Joint::kLeftEye},        {7, Joint::kRightEye},
    {10, Joint::kLeftShoulder}, {11, Joint::kRightShoulder}, {12, Joint::kLeftElbow},
    {13, Joint::kRightElbow},   {14, Joint::kLeftWrist},     {15, Joint::kRightWrist},
    {18, Joint::kLeftHip},      {19, Joint::kRightHip},      {20, Joint::kLeftKnee},
    {21, Joint::kRightKnee},    {22, Joint::kLeftAnkle},     {23, Joint::kRightAnkle},
    {24, Joint::kLeftFoot},     {25, Joint::kRightFoot}};

/// The head's bone begins at its joint with the neck; its middle is above, along the bone's y.
constexpr double kHeadAboveItsJoint = 0.09;

void refuse_vmc(ParsedSkeletons& parsed, const char* why) {
  ++parsed.malformed;
  parsed.why = why;
}

/// Seven numbers; nullptr when all is well.
const char* read_vmc_pose(ByteReader& in, std::string_view types, Pose& pose) {
  std::array<double, 7> v{};
  for (std::size_t i = 0; i < 7; ++i) {
    if (types[i] != 'f' && types[i] != 'd') return "a VMC pose is not of seven floats";
    v[i] = types[i] == 'f' ? in.real32(true) : in.real64(true);
    // Written so that NaN fails the comparison.
    if (!(std::abs(v[i]) <= kFarthestJoint)) return "a VMC pose is not finite, or beyond 20 m";
  }
  if (in.bad) return "a VMC message is cut short";
  Eigen::Quaterniond turn(v[6], v[3], v[4], v[5]);
  if (!(std::abs(turn.norm() - 1) < 0.05)) return "a VMC quaternion is no rotation";
  pose = Pose(turn.normalized(), Vec3(v[0], v[1], v[2]));
  return nullptr;
}

}  // namespace

ParsedSkeletons VmcReader::parse(std::string_view datagram) {
  ParsedSkeletons parsed;
  read(datagram, 0, parsed);
  return parsed;
}

void VmcReader::read(std::string_view bytes, int depth, ParsedSkeletons& parsed) {
  if (bytes.substr(0, track::internal::kOscBundle.size()) != track::internal::kOscBundle)
    return read_message(bytes, parsed);
  if (depth == limits::kOscDepth) return refuse_vmc(parsed, "OSC bundles are nested too deeply");
  ByteReader in{bytes.substr(track::internal::kOscBundle.size())};
  in.take(8);  // the time tag: senders leave it at "now"
  while (!in.bad && !in.rest.empty()) {
    const std::string_view element = in.take(in.number<std::uint32_t>(true));
    if (!in.bad) read(element, depth + 1, parsed);
  }
  if (in.bad) refuse_vmc(parsed, "an OSC bundle is cut short");
}

void VmcReader::read_message(std::string_view bytes, ParsedSkeletons& parsed) {
  ByteReader in{bytes};
  const std::string_view address = track::internal::osc_text(in), types = track::internal::osc_text(in);
  constexpr std::string_view kOurs = "/VMC/Ext/";
  if (in.bad || address.substr(0, kOurs.size()) != kOurs) return refuse_vmc(parsed, "it is no VMC message");
  if (address == "/VMC/Ext/OK") {
    if (types.substr(0, 2) != ",i") return refuse_vmc(parsed, "/VMC/Ext/OK without a number");
    const bool is_loaded = in.number<std::uint32_t>(true) != 0;
    if (in.bad) return refuse_vmc(parsed, "a VMC message is cut short");
    if (is_loaded) return;
    known_.reset();
    arrived_.reset();
    parsed.frames.emplace_back();
    return;
  }
  const bool is_root = address == "/VMC/Ext/Root/Pos";
  if (!is_root && address != "/VMC/Ext/Bone/Pos") return;  // faces, cameras, lights, trackers
  // A root may tell a scale and an offset behind its pose, which are for pictures.
  if (types.size() < 9 || types.substr(0, 2) != ",s" || (!is_root && types.size() != 9))
    return refuse_vmc(parsed, "a VMC pose is a name and seven floats");
  const std::string_view name = track::internal::osc_text(in);
  Pose pose;
  if (const char* why = read_vmc_pose(in, types.substr(2, 7), pose)) return refuse_vmc(parsed, why);
  if (is_root) {
    root_ = pose;
    return;
  }
  for (std::size_t i = 0; i < kBones; ++i) {
    if (name != kVmcBones[i].name) continue;
    if (arrived_[i]) end_frame(parsed);
    bones_[i] = pose;
    arrived_.set(i);
    if (known_.any() && (arrived_ & known_) == known_) end_frame(parsed);
    return;
  }
}

void VmcReader::end_frame(ParsedSkeletons& parsed) {
  const std::bitset<kBones> there = arrived_;
  // A bone that comes alone between frames is not a frame; it was sent twice.
  const bool is_whole = there[0] && there.count() >= 3;
  if (is_whole) known_ = there;
  arrived_.reset();
  if (!is_whole) return;

  std::array<Pose, kBones> world;
  double longest = 0;
  Skeleton person;
  std::array<Vec3, kBones> at;
  for (std::size_t i = 0; i < kBones; ++i) {
    if (!there[i]) continue;
    int parent = kVmcBones[i].parent;
    while (parent >= 0 && !there[std::size_t(parent)]) parent = kVmcBones[std::size_t(parent)].parent;
    world[i] = (parent < 0 ? root_ : world[std::size_t(parent)]) * bones_[i];
    if (i > 0) longest = std::max(longest, bones_[i].translation.norm());
    const Vec3& p = world[i].translation;
    at[i] = Vec3(p.x(), -p.y(), p.z());
  }
  if (longest < 0.01)
    return refuse_vmc(parsed, "all bones lie in one place: the sender tells rotations alone");
  for (const auto& [bone, joint] : kVmcJoints)
    if (there[bone]) person[joint] = SeenJoint<Vec3>{at[bone], 1};
  if (!there[3] && there[2]) person[Joint::kChest] = SeenJoint<Vec3>{at[2], 1};
  if (there[kVmcHead]) {
    const Vec3 middle = world[kVmcHead] * Vec3(0, kHeadAboveItsJoint, 0);
    person[Joint::kHead] = SeenJoint<Vec3>{Vec3(middle.x(), -middle.y(), middle.z()), 1};
  }
  for (const Side side : {Side::kLeft, Side::kRight}) {
    const std::size_t hand = kVmcLeftHand + std::size_t(side), finger = kVmcLeftMiddle + std::size_t(side);
    if (there[hand] && there[finger])  // the palm lies between wrist and knuckle
      person[of_side(Joint::kLeftHand, side)] = SeenJoint<Vec3>{(at[hand] + at[finger]) / 2, 1};
  }
  SkeletonFrame frame;
  frame.people.push_back(std::move(person));
  if (const char* why = why_refused(frame)) return refuse_vmc(parsed, why);
  parsed.frames.push_back(std::move(frame));
}

}  // namespace procam::people
