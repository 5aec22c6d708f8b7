#pragma once
/// A pan-tilt head: two axes, and the pose of its tilting part by the two angles.
///
///   head_from_tilt(axes, pan, tilt) = Rz(pan) Tx(offset) Rx(angle) Rz(tilt)
///
/// The head's z axis is the pan axis, the tilting part's z axis the tilt axis; both point so that the reported angles
/// grow by the right-hand rule. The head's origin is the foot of the common perpendicular on the pan axis. These are the
/// four parameters of J. Denavit and R. Hartenberg, "A kinematic notation for lower-pair mechanisms based on matrices",
/// J. Applied Mechanics 22, 1955, without the two that are redundant here: zero angles and offsets along the axes belong
/// to world_from_head and tilt_from_rig.
#include "procam/core/geometry/covariance.hpp"

namespace procam {

/// The invariants of two lines in space.
struct PanTiltAxes {
  double offset = 0;       ///< from the pan axis to the tilt axis along the common perpendicular, metres
  double angle = kPi / 2;  ///< from the pan axis to the tilt axis about the common perpendicular, radians
};

/// Angles in radians, as the head reports them.
inline Pose head_from_tilt(const PanTiltAxes& axes, double pan, double tilt) {
  const Pose arm(so3_exp(Vec3(axes.angle, 0, 0)), Vec3(axes.offset, 0, 0));
  return Pose(so3_exp(Vec3(0, 0, pan)), Vec3::Zero()) * arm * Pose(so3_exp(Vec3(0, 0, tilt)), Vec3::Zero());
}

}  // namespace procam
