#pragma once
/// A moving robot: the true pose of its rig at any time, and the poses that a localiser reports.
///
///   world_from_rig(start + t) = world_from_rig(start) * se3_exp(increment * share(t / duration))
///
/// The twist is of the rig in its own frame, [rotation, translation], increments on the right:
///   d/dt world_from_rig = world_from_rig * hat(twist),   twist = increment * share'(t / duration) / duration
///
/// A Drive is a Motion: room_view() takes it as it is, or drive * rig_from_camera.
#include <cstdint>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/simulate/motion.hpp"

namespace procam::simulate {

/// One leg: a screw motion by `increment` = [rotation, translation] in the rig's frame at its start.
struct Leg {
  Vec6 increment = Vec6::Zero();
  double duration = 1;  ///< seconds
  /// From rest to rest: share(x) = 10 x^3 - 15 x^4 + 6 x^5, the motion of least jerk (T. Flash, N. Hogan,
  /// "The coordination of arm movements", J. Neuroscience 5(7), 1985). Else share(x) = x, a constant twist.
  bool rest_to_rest = false;
};

class PROCAM_EXPORT Drive {
 public:
  /// Throws std::invalid_argument for a duration that is not positive or a number that is not finite.
  Drive(const Pose& world_from_rig_at_start, const std::vector<Leg>& legs, double start_time = 0);

  double start_time() const { return start_time_; }
  double end_time() const { return starts_.back(); }
  /// It stands still before its start and after its end.
  Pose world_from_rig(double time) const;
  /// [rotation, translation] in the rig's frame, rad/s and m/s; at a joint, of the leg that begins.
  Vec6 twist(double time) const;
  Pose operator()(double time) const { return world_from_rig(time); }

 private:
  double start_time_;
  std::vector<Leg> legs_;
  std::vector<double> starts_;        ///< of each leg, and the end
  std::vector<Pose> world_from_leg_;  ///< at each start, and at the end

  std::size_t leg_at(double time) const;
};

/// The same twist all along.
PROCAM_EXPORT Leg constant_twist(const Vec6& twist, double duration);

/// Once round a circle in the rig's x-y plane, x ahead (a robot's base, z up): a positive radius turns left,
/// a negative one right. `turns` may be any number above zero. Speed in m/s, above zero.
PROCAM_EXPORT Leg circle(double radius, double speed, double turns = 1);

struct Waypoint {
  Pose world_from_rig;
  double time = 0;  ///< of arrival, seconds
};
/// From waypoint to waypoint along screws, resting at each; the first gives start and start time. Throws
/// std::invalid_argument for fewer than two, or times that do not grow.
PROCAM_EXPORT Drive drive_through(const std::vector<Waypoint>& waypoints);

struct Localiser {
  double rate = 20;           ///< messages a second
  double delay = 0.05;        ///< from the moment that a message speaks of to its arrival, seconds
  double jitter = 0;          ///< sigma of the delay, seconds; no message arrives before its stamp
  double position_sigma = 0;  ///< metres, each axis of the world
  double rotation_sigma = 0;  ///< radians, about each axis of the rig
  double dropped = 0;         ///< share of messages that never arrive
  std::uint64_t seed = 0;
};

struct LocalisedPose {
  double stamp = 0;    ///< the moment it speaks of, seconds
  double arrival = 0;  ///< when it is known, seconds
  Pose measured;       ///< world_from_rig: (R exp(rotation noise), t + position noise)
  Pose truth;
};

/// Messages stamped start, start + 1 / rate, ... up to the drive's end, in the order of arrival (jitter above
/// the period lets them overtake each other). Equal seeds give equal messages, and dropping some changes
/// nothing in the others. Throws std::invalid_argument for numbers out of range.
PROCAM_EXPORT std::vector<LocalisedPose> localise(const Drive& drive, const Localiser& localiser);

}  // namespace procam::simulate
