#pragma once
/// Where a device is at a time.
#include <functional>
#include <type_traits>
#include <utility>

#include "procam/core/geometry/pose.hpp"

namespace procam::simulate {

/// target_from_source over time, seconds: one pose for ever, or a function such as a Drive. Both convert by
/// themselves where a Motion is asked for.
class Motion {
 public:
  Motion(const Pose& target_from_source = {}) : pose_(target_from_source) {}
  template <typename PoseAt, typename = std::enable_if_t<std::is_invocable_r_v<Pose, const PoseAt&, double> &&
                                                         !std::is_same_v<PoseAt, Motion>>>
  Motion(PoseAt pose_at) : pose_at_(std::move(pose_at)) {}

  bool is_still() const { return !pose_at_; }
  Pose operator()(double time) const { return pose_at_ ? pose_at_(time) : pose_; }

 private:
  Pose pose_;
  std::function<Pose(double)> pose_at_;
};

/// room_from_camera = room_from_rig * rig_from_camera, for a camera that rides on a rig.
inline Motion operator*(const Motion& target_from_middle, const Pose& middle_from_source) {
  if (target_from_middle.is_still()) return Motion(target_from_middle(0) * middle_from_source);
  return Motion([=](double time) { return target_from_middle(time) * middle_from_source; });
}

}  // namespace procam::simulate
