#include "procam/people/skeleton.hpp"

#include <cmath>

#include "procam/core/base/detail/plain_text.hpp"
#include "procam/core/base/limits.hpp"

namespace procam::people {
namespace {

constexpr std::array<const char*, kJointCount> kNames = {
    "head",          "nose",           "left_eye",   "right_eye",   "left_ear",      "right_ear",
    "neck",          "chest",          "navel",      "pelvis",      "left_shoulder", "right_shoulder",
    "left_elbow",    "right_elbow",    "left_wrist", "right_wrist", "left_hand",     "right_hand",
    "left_hand_tip", "right_hand_tip", "left_thumb", "right_thumb", "left_hip",      "right_hip",
    "left_knee",     "right_knee",     "left_ankle", "right_ankle", "left_foot",     "right_foot"};

std::optional<Vec3> middle(const Skeleton& person, Joint left) {
  const auto &a = person[left], &b = person[of_side(left, Side::kRight)];
  if (!a || !b) return std::nullopt;
  return Vec3((a->position + b->position) / 2);
}

}  // namespace

const char* to_string(Joint joint) {
  return kNames[std::size_t(joint)];
}

std::optional<Joint> joint_of(std::string_view name) {
  for (std::size_t i = 0; i < kJointCount; ++i)
    if (name == kNames[i]) return Joint(i);
  return std::nullopt;
}

const char* why_refused(const SkeletonFrame& frame) {
  if (frame.stamp && !(std::abs(*frame.stamp) <= 1e12)) return "the stamp is not a time in seconds";
  if (frame.frame.size() > limits::kFrameNameBytes || !procam::internal::is_plain_text(frame.frame))
    return "the frame's name is not UTF-8, has control characters, or is longer than 255 bytes";
  if (frame.people.size() > limits::kPeople) return "it holds more than 16 people";
  for (const Skeleton& person : frame.people)
    for (const auto& seen : person.joints) {
      if (!seen) continue;
      // Written so that NaN fails the comparison.
      if (!(seen->position.cwiseAbs().maxCoeff() <= kFarthestJoint) || !seen->position.allFinite())
        return "a joint is not finite, or beyond 20 m";
      if (!(seen->confidence >= 0 && seen->confidence <= 1)) return "a confidence is not within 0 and 1";
    }
  return nullptr;
}

std::optional<Vec3> head_of(const Skeleton& person) {
  if (auto head = person.position(Joint::kHead)) return head;
  if (auto ears = middle(person, Joint::kLeftEar)) return ears;
  if (auto eyes = middle(person, Joint::kLeftEye)) return eyes;
  return person.first_of(Joint::kNose, Joint::kLeftEye, Joint::kRightEye, Joint::kLeftEar, Joint::kRightEar);
}

std::optional<Vec3> body_of(const Skeleton& person) {
  if (auto trunk = person.first_of(Joint::kPelvis, Joint::kNavel, Joint::kChest, Joint::kNeck)) return trunk;
  if (auto hips = middle(person, Joint::kLeftHip)) return hips;
  if (auto shoulders = middle(person, Joint::kLeftShoulder)) return shoulders;
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (const auto& seen : person.joints)
    if (seen) sum += seen->position, ++count;
  if (count == 0) return std::nullopt;
  return Vec3(sum / count);
}

}  // namespace procam::people
