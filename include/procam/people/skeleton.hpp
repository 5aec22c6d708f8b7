#pragma once
/// People as joints: one model for whatever saw them.
///
/// Positions are metres in the sensor's optical frame (x right, y down, z forward; docs/conventions.md). Left
/// is the person's own left. A joint that was not seen is absent, never zero: an all-zero joint is the
/// commonest lie of skeleton trackers, and content that believes it moves to the camera.
///
/// Readers take any bytes (skeleton_reader.hpp); people over time are in people.hpp, what content does with
/// them in interaction.hpp, and how they are kept out of the light in eye_safe.hpp.
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/types.hpp"

namespace procam::people {

/// A closed set: what the readers' joints are mapped to. Sides come as left, right.
enum class Joint {
  kHead,  ///< its middle
  kNose,
  kLeftEye,
  kRightEye,
  kLeftEar,
  kRightEar,
  kNeck,    ///< its base, between the shoulders
  kChest,   ///< the spine at the chest
  kNavel,   ///< the spine at the navel
  kPelvis,  ///< between the hips
  kLeftShoulder,
  kRightShoulder,
  kLeftElbow,
  kRightElbow,
  kLeftWrist,
  kRightWrist,
  kLeftHand,  ///< the palm
  kRightHand,
  kLeftHandTip,
  kRightHandTip,
  kLeftThumb,
  kRightThumb,
  kLeftHip,
  kRightHip,
  kLeftKnee,
  kRightKnee,
  kLeftAnkle,
  kRightAnkle,
  kLeftFoot,  ///< the toes
  kRightFoot,
};
inline constexpr std::size_t kJointCount = std::size_t(Joint::kRightFoot) + 1;

/// As in files: "left_wrist".
PROCAM_EXPORT const char* to_string(Joint joint);
PROCAM_EXPORT std::optional<Joint> joint_of(std::string_view name);

enum class Side { kLeft, kRight };
/// The joint of that side; `left` is one of the left joints.
constexpr Joint of_side(Joint left, Side side) {
  return Joint(int(left) + (side == Side::kRight ? 1 : 0));
}

template <typename Point>
struct SeenJoint {
  Point position = Point::Zero();
  double confidence = 1;  ///< 0..1, as the tracker says; 1 when it says nothing
};

/// Point: Vec3, metres in the sensor's frame; or Vec2, pixels.
template <typename Point>
struct SkeletonT {
  std::array<std::optional<SeenJoint<Point>>, kJointCount> joints;
  std::optional<std::int64_t> id;  ///< the sender's number for the person

  std::optional<SeenJoint<Point>>& operator[](Joint joint) { return joints[std::size_t(joint)]; }
  const std::optional<SeenJoint<Point>>& operator[](Joint joint) const { return joints[std::size_t(joint)]; }
  std::optional<Point> position(Joint joint) const {
    const auto& seen = joints[std::size_t(joint)];
    return seen ? std::optional<Point>(seen->position) : std::nullopt;
  }
  /// The first that was seen.
  template <typename... Joints>
  std::optional<Point> first_of(Joints... wanted) const {
    for (const Joint joint : {wanted...})
      if (const auto& seen = joints[std::size_t(joint)]) return seen->position;
    return std::nullopt;
  }
};
using Skeleton = SkeletonT<Vec3>;
using PixelSkeleton = SkeletonT<Vec2>;

/// Everybody that the sensor saw at one moment; nobody is news as well.
struct SkeletonFrame {
  std::optional<double> stamp;  ///< sender's clock, seconds (clocks: stamped_pose.hpp)
  double arrival = 0;           ///< local steady clock, seconds
  std::string frame;            ///< the sensor's; may be empty
  std::vector<Skeleton> people;
};

inline constexpr double kFarthestJoint =
    20;  ///< metres from the sensor along any axis: no body sensor sees beyond

/// nullptr when all is well; else why a frame is refused.
PROCAM_EXPORT const char* why_refused(const SkeletonFrame& frame);

/// Where the hand is: palm, else wrist, else the tip of the fingers.
inline std::optional<Vec3> hand_of(const Skeleton& person, Side side) {
  return person.first_of(of_side(Joint::kLeftHand, side), of_side(Joint::kLeftWrist, side),
                         of_side(Joint::kLeftHandTip, side));
}
/// Where the head is: its middle; else between the ears, between the eyes, the nose.
PROCAM_EXPORT std::optional<Vec3> head_of(const Skeleton& person);
/// Where the person stands: pelvis, navel, chest, neck, the middle of hips or shoulders, else the mean of all
/// joints.
PROCAM_EXPORT std::optional<Vec3> body_of(const Skeleton& person);

}  // namespace procam::people
