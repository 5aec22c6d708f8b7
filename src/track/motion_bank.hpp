#pragma once
/// The models of motion that PoseTrack weighs against each other: interacting multiple models (Blom and
/// Bar-Shalom, IEEE Transactions on Automatic Control 33(8), 1988) over the filter of pose_filter.hpp.
#include <array>
#include <optional>

#include "pose_filter.hpp"
#include "procam/track/pose_track.hpp"

namespace procam::track::internal {

inline constexpr int kMaxModels = 9;

/// A message as the filter takes it.
struct Measured {
  double time = 0;
  bool has_pose = true;  ///< else the pose is the predicted one, and only the twist is measured
  Pose pose;
  Mat6 noise;   ///< that differs from message to message; of the right increment
  Mat6 common;  ///< the rest of what was stated: it moves slowly and cannot be filtered
  std::optional<Vec6> twist;
  Vec6 twist_variance;
};

/// A message and what the models made of it.
struct Kept {
  Measured measured;
  std::array<MotionState, kMaxModels> states;
  std::array<double, kMaxModels> weights = {};  ///< sum 1
};

/// One answer out of several: the mean in the tangent space of the first, and the scatter of the models
/// beside their own covariance.
struct Mixed {
  Pose pose;
  Vec6 twist = Vec6::Zero();
  Mat6 covariance = Mat6::Zero();  ///< of the right increment
  Mat6 twist_covariance = Mat6::Zero();
};

/// Turning and moving each have their own way of changing, and every pair of ways is a model: a robot that
/// brakes on a straight line turns as steadily as before, and noise of its rotation, which is what moves the
/// light most, stays filtered.
class MotionBank {
 public:
  explicit MotionBank(const TrackOptions& options);

  /// At a first message, every model as likely as the others.
  Kept start(const Measured& m, const Vec6& twist, const Mat6& twist_covariance) const;
  /// One step: mix, advance, weigh, update. `m` is not older than `before`.
  Kept next(const Kept& before, const Measured& m) const;
  /// Does a model find `m` where it expects it: within `gate` (chi-square of 6 degrees of freedom), or
  /// nearer than `near_turn` (rad) and `near_move` (m)?
  bool expects(const Kept& before, const Measured& m, double gate, double near_turn, double near_move) const;
  /// The answer `seconds` after a message, without that message's common part.
  Mixed after(const Kept& kept, double seconds) const;

 private:
  std::array<MotionModel, kMaxModels> models_;
  int count_ = 0;
  int side_ = 1;  ///< ways of moving; the model of turning i and moving k is i * side_ + k
};

}  // namespace procam::track::internal
