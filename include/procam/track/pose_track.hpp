#pragma once
/// A stream of noisy, late poses -> where the child is at any moment, above all at the moment of light.
///
///   PoseTrack track(options);
///   for (const StampedPose& message : arrived) track.add(message);
///   const TrackedPose seen = track.at(now + output_delay);      // frame_from_child with covariance
///
/// State: the pose T = frame_from_child, its twist v and the twist's rate a, both of the child in its own
/// frame, [rotation, translation]. Between messages
///   T(t + h) = T(t) exp(hat(v h + a h^2 / 2)),   dv = a dt + dw_v,   da = -(a / tau) dt + dw_a,
/// a constant twist (a = 0), or an acceleration that fades with tau (R. A. Singer, "Estimating optimal
/// tracking filter performance for manned maneuvering targets", IEEE AES 6(4), 1970). The estimate is an
/// error-state Kalman filter on SE(3) (Barfoot, "State Estimation for Robotics", 2017, chapter 8; J. Sola,
/// "Quaternion kinematics for the error-state Kalman filter", 2017) with the errors of T on the right. A
/// message's twist and gyro rate are measurements of v. Nine such filters (turning and moving each steady,
/// accelerating or sudden) run side by side as interacting multiple models (H. Blom, Y. Bar-Shalom, "The
/// interacting multiple model algorithm for systems with Markovian switching coefficients", IEEE TAC 33(8),
/// 1988).
///
/// The standard deviation of the messages is measured from their third differences, so that a localiser
/// that states too much (AMCL: where the map may be wrong, not what differs from message to message) or
/// nothing is filtered right. What it states beyond its scatter stays in the covariance that is handed out.
///
/// A message that does not know its pose (kUnknownPoseVariance) measures the twist alone: between two poses the state is
/// dead-reckoned.
///
/// Messages may come twice, late or in the wrong order: the filter keeps its last states and goes back as far
/// as they reach. What it refuses or corrects is counted in Faults.
///
/// A localiser that changes its mind about the map shows as messages that agree with each other and not with
/// the prediction: after `confirm` of them the track follows, and what is handed out moves there along the
/// geodesic within `blend` seconds.
///
/// Not thread-safe: one thread adds and asks. After construction nothing is allocated, except by names of
/// frames longer than those seen.
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/track/clock.hpp"
#include "procam/track/stamped_pose.hpp"

namespace procam::track {

enum class Prediction {
  kAuto,                  ///< all of them, weighted by how well each predicts the messages
  kConstantTwist,         ///< arcs and straight lines
  kConstantAcceleration,  ///< speeding up and braking
  kNone                   ///< the newest pose as it came: for comparison, and for what is already predicted
};
/// "auto", "twist", "acceleration", "none". Throws Error(kInput).
PROCAM_EXPORT Prediction parse_prediction(const std::string& text);
PROCAM_EXPORT const char* to_string(Prediction prediction);

struct TrackOptions {
  /// Which messages are meant; empty takes the names of the first message.
  std::string frame, child;
  Prediction prediction = Prediction::kAuto;
  ClockOptions clock;
  /// From the moment that a message speaks of to its arrival at the fastest (sensor, localiser, network),
  /// seconds: what no clock can tell (clock.hpp). With ClockOptions::known_offset: zero, if stamps are right.
  /// Messages without a stamp are taken to be this old.
  double delay = 0;
  /// Of a message that states no covariance, until the track has measured it, and where it cannot: one sigma,
  /// metres and radians.
  double position_sigma = 0.01, rotation_sigma = 0.01;
  /// Of a stated twist and a gyro's rate (its bias included), m/s and rad/s.
  double speed_sigma = 0.03, turn_sigma = 0.02;
  /// What the robot can do, one sigma: m/s^2, rad/s^2. Larger follows quicker and smooths less.
  double acceleration = 0.5, turn_acceleration = 1.0;
  /// No pose moves faster; what seems to, jumps. m/s, rad/s.
  double max_speed = 5, max_turn = 10;
  double stale_after = 0.5;  ///< seconds without news, after which the state is kStale and the pose frozen
  int confirm = 3;           ///< messages in a row that agree on another place, before it is believed
  double blend = 0.5;        ///< seconds in which the picture moves there
};

enum class TrackState {
  kNone,   ///< no message yet
  kFresh,  ///<
  kStale   ///< the newest pose is older than stale_after at the time asked for
};
PROCAM_EXPORT const char* to_string(TrackState state);

struct TrackedPose {
  TrackState state = TrackState::kNone;
  Pose frame_from_child;
  /// Of the left increment [rotation, translation] in `frame`; grows with age. Not told by it: what is left
  /// of a blend.
  Mat6 covariance = Mat6::Zero();
  Vec6 twist = Vec6::Zero();  ///< at the time asked for, in the child's own frame
  double age = 0;             ///< time asked for less that of the newest pose, seconds; negative in the past
  double blend_left = 0;      ///< 1 right after the map jumped, 0 when the pose is where the messages say
};

/// Every message that add() got is counted in exactly one of `taken` .. `pending`; a refused message leaves
/// no trace in the pose. The last five are events.
struct Faults {
  std::uint64_t taken = 0;       ///< in order and believed
  std::uint64_t reordered = 0;   ///< overtaken by a newer one, put in its place and believed
  std::uint64_t late = 0;        ///< older than all that is kept: refused
  std::uint64_t duplicated = 0;  ///< the same sequence number or stamp again: refused
  std::uint64_t outliers = 0;    ///< a place the child cannot be at, not confirmed: refused
  std::uint64_t doubtful = 0;    ///< a stamp that contradicts the clock: refused (clock.hpp)
  std::uint64_t invalid = 0;     ///< not finite, no rotation, or no pose before the first one: refused
  std::uint64_t foreign = 0;     ///< of other frames: refused
  std::uint64_t pending = 0;     ///< of another place, not decided yet; moves to `outliers` or `taken`

  std::uint64_t map_jumps = 0;    ///< other places that were confirmed
  std::uint64_t clock_jumps = 0;  ///< times the sender's clock was set
  std::uint64_t stale = 0;        ///< gaps longer than stale_after, when they ended
  std::uint64_t lost = 0;         ///< sequence numbers that never came
  /// Messages taken without their twist: over a second it contradicts their poses (drivers that fill in zeros, other axes).
  std::uint64_t twists_ignored = 0;
};
/// Name and value of each count but `pending`: for reports and metrics.
PROCAM_EXPORT std::vector<std::pair<const char*, std::uint64_t>> named_counts(const Faults& faults);

class PROCAM_EXPORT PoseTrack {
 public:
  /// Throws std::invalid_argument for options that are not positive where they must be.
  explicit PoseTrack(const TrackOptions& options = {});
  ~PoseTrack();
  PoseTrack(PoseTrack&&) noexcept;
  PoseTrack& operator=(PoseTrack&&) noexcept;

  /// Takes a message, whatever is in it.
  void add(const StampedPose& message);

  /// frame_from_child at a local time: between kept poses interpolated (a cubic through both with their
  /// twists), after the newest predicted, no further than stale_after; before the oldest kept, the oldest.
  TrackedPose at(double time) const;

  const Faults& faults() const;
  Clock::Estimate clock() const;
  /// The names this track follows; empty before the first message when the options give none.
  const std::string& frame() const;
  const std::string& child() const;
  /// What the messages scatter by, measured from their third differences, or as stated where that is not
  /// known yet: sigmas of [rotation, translation] in the child's frame.
  Vec6 noise() const;
  double newest_time() const;  ///< of the newest pose believed; 0 before the first

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace procam::track
