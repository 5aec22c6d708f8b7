// Joints as other makers list them, and pixels or hip-centred joints to the sensor's frame.
#include <algorithm>
#include <cmath>
#include <limits>

#include "joint_sets.hpp"
#include "procam/core/base/error.hpp"
#include "procam/people/skeleton_reader.hpp"

namespace procam::people {

Skeleton from_joint_set(JointSet set, const std::vector<ForeignJoint>& joints) {
  const bool is_azure = set == JointSet::kAzureKinect;
  const std::size_t count = is_azure ? internal::kAzure.size() : internal::kKinect2.size();
  require(joints.size() == count, "from_joint_set: " + std::to_string(joints.size()) +
                                      " joints, the set has " + std::to_string(count));
  Skeleton person;
  for (std::size_t i = 0; i < count; ++i) {
    const internal::MaybeJoint joint = is_azure ? internal::kAzure[i] : internal::kKinect2[i];
    const ForeignJoint& seen = joints[i];
    if (!joint || seen.confidence <= 0 || !seen.position.allFinite()) continue;
    // x to the sensor's left and y up, seen along z: half a turn about z makes it optical.
    const Vec3 position = is_azure ? Vec3(seen.position * 1e-3)
                                   : Vec3(-seen.position.x(), -seen.position.y(), seen.position.z());
    person[*joint] = SeenJoint<Vec3>{position, std::min(1.0, seen.confidence / (is_azure ? 3.0 : 2.0))};
  }
  return person;
}

Skeleton lifted(const PixelSkeleton& seen, const Camera& camera,
                const std::function<std::optional<double>(const Vec2&)>& depth_at) {
  require(bool(depth_at), "lifted: no function for the depth");
  Skeleton person;
  person.id = seen.id;
  for (std::size_t i = 0; i < kJointCount; ++i) {
    if (!seen.joints[i]) continue;
    const std::optional<Vec3> bearing = camera.unproject(seen.joints[i]->position);
    if (!bearing || !(bearing->z() > 1e-3)) continue;
    const std::optional<double> depth = depth_at(seen.joints[i]->position);
    if (!depth || !(*depth > 0 && *depth <= kFarthestJoint)) continue;
    person.joints[i] = SeenJoint<Vec3>{*bearing * (*depth / bearing->z()), seen.joints[i]->confidence};
  }
  return person;
}

Skeleton anchored(const Skeleton& about_hips, const Vec3& hips_in_sensor) {
  require(hips_in_sensor.allFinite(), "anchored: the hips' position is not finite");
  Skeleton person = about_hips;
  for (auto& seen : person.joints)
    if (seen) seen->position += hips_in_sensor;
  return person;
}

std::optional<Skeleton> anchored_on_floor(const Skeleton& about_hips, const Vec3& bearing,
                                          const Plane& floor_in_sensor) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Joint left : {Joint::kLeftAnkle, Joint::kLeftFoot})
    for (const Side side : {Side::kLeft, Side::kRight})
      if (const auto& foot = about_hips[of_side(left, side)])
        lowest = std::min(lowest, floor_in_sensor.normal.dot(foot->position));
  const double closing = floor_in_sensor.normal.dot(bearing);
  if (!std::isfinite(lowest) || !(std::abs(closing) > 1e-6 * bearing.norm())) return std::nullopt;
  const double s = -(floor_in_sensor.offset + lowest) / closing;
  if (!(s > 0) || !(s * bearing.cwiseAbs().maxCoeff() <= kFarthestJoint)) return std::nullopt;
  return anchored(about_hips, s * bearing);
}

}  // namespace procam::people
