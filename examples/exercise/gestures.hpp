#pragma once
/// The angle of a raised arm, its repetitions, and what a raised hand means.
#include <optional>
#include <vector>

#include "procam/core/base/types.hpp"
#include "procam/people/skeleton.hpp"

namespace exercise {

namespace people = procam::people;
using procam::kDegree;

/// Shoulder abduction, radians: the angle between the trunk and the upper arm in the frontal plane, 0 hanging
/// down, 90 degrees level. With d down the trunk (neck to pelvis) and l across the shoulders to the arm's
/// side, square to d,
///   angle = atan2(arm . l, arm . d).
/// A depth camera's noise lies along its axis, which the frontal plane excludes when the person faces it;
/// the angle in space does not, and is 30 degrees too large for an arm that hangs. nullopt when a joint is
/// missing, or the arm points out of the plane (less than 0.3 of it lies within).
std::optional<double> abduction_angle(const people::Skeleton& person, people::Side side);

struct ExerciseOptions {
  double target = 80 * kDegree;  ///< reached: the repetition counts
  double rest = 40 * kDegree;    ///< below it the next one begins
};

/// Counts how often an angle reaches its target, from rest to rest: an arm that trembles at the target counts
/// once.
class ExerciseCounter {
 public:
  enum class Event { kNone, kReached, kRested };
  explicit ExerciseCounter(const ExerciseOptions& options = {});
  Event update(const std::optional<double>& angle);
  int count() const { return count_; }
  /// The largest angle of this repetition so far, or of the last one.
  double best() const { return best_; }

 private:
  ExerciseOptions options_;
  bool is_armed_ = false;  ///< it must rest first
  int count_ = 0;
  double best_ = 0;
};

/// What a raised hand says.
enum class HandSign {
  kNone,   ///< it was not raised
  kWave,   ///< "hello": it goes to and fro
  kStill,  ///< "high five": it is held up
};

struct HandSignOptions {
  /// Heights of the wrist below the neck, in lengths of the trunk (neck to pelvis).
  double raised = 0.3, lowered = 0.5;
  int settle = 3;  ///< frames after raising and before lowering that are ignored
  /// The wrist's way across, seen from its elbow, in trunks a frame. 0.0195 lies between the gestures of a
  /// recording of four each: 0.023 to 0.047 for waves, 0.007 to 0.016 for hands held up.
  double sway = 0.0195;
};

struct RaisedHand {
  HandSign sign = HandSign::kNone;
  int frames = 0;   ///< of the longest time that it was up
  double sway = 0;  ///< as in the options
};

/// In pictures of one person, one after the other (10 to 30 a second), upright.
RaisedHand read_hand(const std::vector<people::PixelSkeleton>& frames, people::Side side,
                     const HandSignOptions& options = {});

}  // namespace exercise
