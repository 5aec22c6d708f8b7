#pragma once
/// Bytes -> skeletons: procam's own JSON line, recorded CSV logs, OpenPose, MediaPipe, Azure Kinect, Kinect
/// v2. Layouts are in docs/people.md.
///
/// Parsers take any bytes. What is no frame is counted with its reason and skipped: numbers that are not
/// finite, a joint beyond kFarthestJoint, more people than limits::kPeople, a joint twice or unknown, lists of a
/// wrong length. A joint that the tracker did not see (null, empty, NaN in a CSV, confidence 0, the stale flag)
/// is absent.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/plane.hpp"
#include "procam/core/lens/camera.hpp"
#include "procam/people/skeleton.hpp"

namespace procam::people {

struct ParsedSkeletons {
  std::vector<SkeletonFrame> frames;
  std::uint64_t malformed = 0;
  std::string why;  ///< of the last malformed one
};

/// One frame a line:
///   {"stamp": 12.5, "frame": "camera", "people": [{"id": 3, "joints": {"left_wrist": [x, y, z, confidence],
///   ...}}]}
/// stamp, frame, id and the confidence may be omitted; null for a joint is absent.
PROCAM_EXPORT ParsedSkeletons parse_skeletons(std::string_view lines);
/// What parse_skeletons() reads back; ends in a newline.
PROCAM_EXPORT std::string to_json_line(const SkeletonFrame& frame);

/// A file of JSON lines or CSV, recognised by its first byte. Throws Error: kIo for a file that cannot be
/// read, kInput for one without a single frame.
PROCAM_EXPORT std::vector<SkeletonFrame> read_skeleton_log(const std::filesystem::path& file);

/// OpenPose's JSON of one picture (BODY_25): pixels alone. A keypoint of confidence 0 is absent.
struct PixelPeople {
  std::vector<PixelSkeleton> people;
  std::string why;  ///< empty unless the text was refused
};
PROCAM_EXPORT PixelPeople parse_openpose(std::string_view text);
/// Pixels to metres where the depth (along the optical axis, metres; nullopt where there is none) is known.
PROCAM_EXPORT Skeleton lifted(const PixelSkeleton& seen, const Camera& camera,
                              const std::function<std::optional<double>(const Vec2&)>& depth_at);

/// MediaPipe's pose landmarks: "worldLandmarks" (33 of x, y, z, visibility a person) are metres about the
/// middle of the hips, axes as the camera's; "landmarks" are fractions of the picture, if there. To be
/// anchored before use.
struct HipCentredPerson {
  Skeleton about_hips;
  std::optional<Vec2> hips_in_picture;  ///< fractions, (0, 0) and (1, 1) the picture's corners
};
struct HipCentredPeople {
  std::vector<HipCentredPerson> people;
  std::string why;  ///< empty unless the text was refused
};
PROCAM_EXPORT HipCentredPeople parse_mediapipe(std::string_view text);
/// By depth: the hips are where a depth camera sees them, `hips_in_sensor`.
PROCAM_EXPORT Skeleton anchored(const Skeleton& about_hips, const Vec3& hips_in_sensor);
/// By the floor: the hips lie along `bearing`, as far as puts the lowest ankle or foot p on the floor n.x + d
/// = 0:
///   s = -(d + min n.p) / (n.bearing),    n pointing up.
/// nullopt when no foot was seen, or the bearing does not lead there.
PROCAM_EXPORT std::optional<Skeleton> anchored_on_floor(const Skeleton& about_hips, const Vec3& bearing,
                                                        const Plane& floor_in_sensor);

/// Joints as a device's own list has them, in its order, units and axes.
enum class JointSet {
  kAzureKinect,  ///< k4abt: 32 joints, millimetres, optical axes; confidence 0 none, 1 low, 2 medium, 3 high
  kKinectV2,     ///< 25 joints, metres, x to the sensor's left, y up; confidence 0 not tracked, 1 inferred, 2
                 ///< tracked
};
struct ForeignJoint {
  Vec3 position = Vec3::Zero();
  int confidence = 0;  ///< the set's own level
};
/// Throws std::invalid_argument for a list of another length. Positions that are not finite are absent.
PROCAM_EXPORT Skeleton from_joint_set(JointSet set, const std::vector<ForeignJoint>& joints);
/// Azure Kinect's recorded JSON: frames with timestamp_usec and bodies with joint_positions of 32 triples.
PROCAM_EXPORT ParsedSkeletons parse_azure_kinect(std::string_view text);

}  // namespace procam::people
