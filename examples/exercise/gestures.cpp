#include "gestures.hpp"

#include <algorithm>
#include <cmath>

#include "procam/core/base/error.hpp"

namespace exercise {

using people::Joint;
using people::of_side;
using people::PixelSkeleton;
using people::Side;
using people::Skeleton;
using procam::require;
using procam::Vec3;

std::optional<double> abduction_angle(const Skeleton& person, Side side) {
  const Side other = side == Side::kLeft ? Side::kRight : Side::kLeft;
  const auto shoulder = person.position(of_side(Joint::kLeftShoulder, side));
  const auto across_from = person.position(of_side(Joint::kLeftShoulder, other));
  const auto elbow = person.position(of_side(Joint::kLeftElbow, side));
  const auto neck = person.position(Joint::kNeck), pelvis = person.position(Joint::kPelvis);
  if (!shoulder || !across_from || !elbow || !neck || !pelvis) return std::nullopt;
  const Vec3 trunk = *pelvis - *neck, arm = *elbow - *shoulder;
  const double kShortest = 0.05;  // metres: joints on top of each other have no direction
  if (!(trunk.norm() > kShortest) || !(arm.norm() > kShortest)) return std::nullopt;
  const Vec3 down = trunk.normalized();
  Vec3 across = *shoulder - *across_from;
  across -= across.dot(down) * down;
  if (!(across.norm() > kShortest)) return std::nullopt;
  across.normalize();
  const double along_across = arm.dot(across), along_down = arm.dot(down);
  if (std::hypot(along_across, along_down) < 0.3 * arm.norm()) return std::nullopt;
  return std::atan2(along_across, along_down);
}

ExerciseCounter::ExerciseCounter(const ExerciseOptions& options) : options_(options) {
  require(options.rest < options.target, "ExerciseOptions: the rest must lie below the target");
}

ExerciseCounter::Event ExerciseCounter::update(const std::optional<double>& angle) {
  if (!angle) return Event::kNone;
  if (*angle < options_.rest) {
    const bool has_returned = !is_armed_;
    is_armed_ = true;
    return has_returned ? Event::kRested : Event::kNone;
  }
  if (is_armed_ && *angle >= options_.target) {
    is_armed_ = false;
    ++count_;
    best_ = *angle;
    return Event::kReached;
  }
  if (!is_armed_ && count_ > 0) best_ = std::max(best_, *angle);
  return Event::kNone;
}

RaisedHand read_hand(const std::vector<PixelSkeleton>& frames, Side side, const HandSignOptions& options) {
  require(options.raised < options.lowered && options.settle >= 0 && options.sway > 0,
          "HandSignOptions: a hand is raised above where it is lowered");
  RaisedHand best;
  std::vector<double> ways;  // of the wrist, from its elbow, while the hand is up
  const auto finish = [&] {
    const int settled = int(ways.size()) - 2 * options.settle;
    if (settled >= 2 && int(ways.size()) > best.frames) {
      double sum = 0;
      for (int i = options.settle + 1; i < options.settle + settled; ++i)
        sum += std::abs(ways[std::size_t(i)] - ways[std::size_t(i - 1)]);
      best.frames = int(ways.size());
      best.sway = sum / settled;
      best.sign = best.sway > options.sway ? HandSign::kWave : HandSign::kStill;
    }
    ways.clear();
  };
  bool is_up = false;
  for (const PixelSkeleton& person : frames) {
    const auto neck = person.position(Joint::kNeck), pelvis = person.position(Joint::kPelvis);
    const auto wrist = person.position(of_side(Joint::kLeftWrist, side));
    const auto elbow = person.position(of_side(Joint::kLeftElbow, side));
    if (!neck || !pelvis || !wrist || !elbow) continue;
    const double trunk = (*pelvis - *neck).norm();
    if (!(trunk > 1)) continue;
    const double below = (wrist->y() - neck->y()) / trunk;
    const bool was_up = is_up;
    is_up = below < (is_up ? options.lowered : options.raised);
    if (was_up && !is_up) finish();
    if (is_up) ways.push_back((wrist->x() - elbow->x()) / trunk);
  }
  finish();
  return best;
}

}  // namespace exercise
