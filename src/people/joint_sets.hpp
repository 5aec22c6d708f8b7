#pragma once
/// The joint lists of other makers, in their order; nullopt: a joint that has no counterpart here.
#include <array>
#include <optional>

#include "procam/people/skeleton.hpp"

namespace procam::people::internal {

using MaybeJoint = std::optional<Joint>;
inline constexpr MaybeJoint kNoJoint = std::nullopt;

/// OpenPose, doc/02_output.md: "Pose Output Format (BODY_25)".
inline constexpr std::array<MaybeJoint, 25> kBody25 = {Joint::kNose,
                                                       Joint::kNeck,
                                                       Joint::kRightShoulder,
                                                       Joint::kRightElbow,
                                                       Joint::kRightWrist,
                                                       Joint::kLeftShoulder,
                                                       Joint::kLeftElbow,
                                                       Joint::kLeftWrist,
                                                       Joint::kPelvis,
                                                       Joint::kRightHip,
                                                       Joint::kRightKnee,
                                                       Joint::kRightAnkle,
                                                       Joint::kLeftHip,
                                                       Joint::kLeftKnee,
                                                       Joint::kLeftAnkle,
                                                       Joint::kRightEye,
                                                       Joint::kLeftEye,
                                                       Joint::kRightEar,
                                                       Joint::kLeftEar,
                                                       Joint::kLeftFoot,
                                                       kNoJoint,
                                                       kNoJoint,
                                                       Joint::kRightFoot,
                                                       kNoJoint,
                                                       kNoJoint};

/// MediaPipe Pose: the 33 landmarks.
inline constexpr std::array<MaybeJoint, 33> kMediaPipe = {Joint::kNose,
                                                          kNoJoint,
                                                          Joint::kLeftEye,
                                                          kNoJoint,
                                                          kNoJoint,
                                                          Joint::kRightEye,
                                                          kNoJoint,
                                                          Joint::kLeftEar,
                                                          Joint::kRightEar,
                                                          kNoJoint,
                                                          kNoJoint,
                                                          Joint::kLeftShoulder,
                                                          Joint::kRightShoulder,
                                                          Joint::kLeftElbow,
                                                          Joint::kRightElbow,
                                                          Joint::kLeftWrist,
                                                          Joint::kRightWrist,
                                                          kNoJoint,
                                                          kNoJoint,
                                                          Joint::kLeftHandTip,
                                                          Joint::kRightHandTip,
                                                          Joint::kLeftThumb,
                                                          Joint::kRightThumb,
                                                          Joint::kLeftHip,
                                                          Joint::kRightHip,
                                                          Joint::kLeftKnee,
                                                          Joint::kRightKnee,
                                                          Joint::kLeftAnkle,
                                                          Joint::kRightAnkle,
                                                          kNoJoint,
                                                          kNoJoint,
                                                          Joint::kLeftFoot,
                                                          Joint::kRightFoot};

/// k4abt_joint_id_t.
inline constexpr std::array<MaybeJoint, 32> kAzure = {Joint::kPelvis,
                                                      Joint::kNavel,
                                                      Joint::kChest,
                                                      Joint::kNeck,
                                                      kNoJoint,
                                                      Joint::kLeftShoulder,
                                                      Joint::kLeftElbow,
                                                      Joint::kLeftWrist,
                                                      Joint::kLeftHand,
                                                      Joint::kLeftHandTip,
                                                      Joint::kLeftThumb,
                                                      kNoJoint,
                                                      Joint::kRightShoulder,
                                                      Joint::kRightElbow,
                                                      Joint::kRightWrist,
                                                      Joint::kRightHand,
                                                      Joint::kRightHandTip,
                                                      Joint::kRightThumb,
                                                      Joint::kLeftHip,
                                                      Joint::kLeftKnee,
                                                      Joint::kLeftAnkle,
                                                      Joint::kLeftFoot,
                                                      Joint::kRightHip,
                                                      Joint::kRightKnee,
                                                      Joint::kRightAnkle,
                                                      Joint::kRightFoot,
                                                      Joint::kHead,
                                                      Joint::kNose,
                                                      Joint::kLeftEye,
                                                      Joint::kLeftEar,
                                                      Joint::kRightEye,
                                                      Joint::kRightEar};

/// JointType of the Kinect for Windows SDK 2. Its SpineShoulder is the base of the neck; its Neck lies above.
inline constexpr std::array<MaybeJoint, 25> kKinect2 = {
    Joint::kPelvis,     Joint::kNavel,       kNoJoint,          Joint::kHead,          Joint::kLeftShoulder,
    Joint::kLeftElbow,  Joint::kLeftWrist,   Joint::kLeftHand,  Joint::kRightShoulder, Joint::kRightElbow,
    Joint::kRightWrist, Joint::kRightHand,   Joint::kLeftHip,   Joint::kLeftKnee,      Joint::kLeftAnkle,
    Joint::kLeftFoot,   Joint::kRightHip,    Joint::kRightKnee, Joint::kRightAnkle,    Joint::kRightFoot,
    Joint::kNeck,       Joint::kLeftHandTip, Joint::kLeftThumb, Joint::kRightHandTip,  Joint::kRightThumb};

}  // namespace procam::people::internal
