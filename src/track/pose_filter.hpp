#pragma once
/// Error-state Kalman filter of a pose, its twist and the twist's rate: the equations of pose_track.hpp.
///
/// Errors act on the right, in the child's frame: T = T^ exp(xi), v = v^ + dv, a = a^ + da. The covariance is
/// kept in its 6x6 blocks: products of that size are unrolled and never ask for memory.
#include "procam/core/base/types.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::track::internal {

/// How the twist changes. A component without `surge` has no acceleration, and its twist walks at random.
struct MotionModel {
  Vec6 walk = Vec6::Zero();     ///< variance that the twist gains a second: (rad/s)^2/s, (m/s)^2/s
  Vec6 surge = Vec6::Zero();    ///< variance of the acceleration: (rad/s^2)^2, (m/s^2)^2
  double acceleration_tau = 1;  ///< seconds after which an acceleration has faded to 1/e
};

struct MotionState {
  Pose pose;  ///< frame_from_child
  Vec6 twist = Vec6::Zero();
  Vec6 rate = Vec6::Zero();     ///< of the twist
  Mat6 pp, pt, pr, tt, tr, rr;  ///< covariance: pose, twist, rate
};

/// At the first message: known place, twist and rate within what a robot does.
MotionState start_motion(const Pose& measured, const Mat6& noise, const Vec6& twist,
                         const Mat6& twist_covariance, const MotionModel& model);

/// `seconds` later; not negative.
MotionState advanced(const MotionState& state, double seconds, const MotionModel& model);

/// One state for several, weighted; the scatter between them is added to the covariance. Of components that
/// accelerate in no way in `model` the rate is forgotten; of a part in which they do not (their variance is
/// zero) the rate is unknown within model.surge.
MotionState mixed(const MotionState* states, const double* weights, int count, const MotionModel& model);

/// xi = log(T^^-1 T_measured), or the measured twist less that of the state, and how surprising it is.
struct Innovation {
  Vec6 xi;
  double chi2 = 0;            ///< 6 degrees of freedom
  double log_likelihood = 0;  ///< less 3 log(2 pi)
};
Innovation innovation(const MotionState& state, const Pose& measured, const Mat6& noise);
Innovation twist_innovation(const MotionState& state, const Vec6& twist, const Vec6& variance);

/// After a measured pose; after a measured twist, whose unmeasured rows have an enormous variance.
MotionState updated_by_pose(const MotionState& state, const Pose& measured, const Mat6& noise);
MotionState updated_by_twist(const MotionState& state, const Vec6& twist, const Vec6& variance);

}  // namespace procam::track::internal
