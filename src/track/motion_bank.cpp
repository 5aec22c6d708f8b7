#include "motion_bank.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace procam::track::internal {
namespace {

/// Seconds for which a way of moving lasts, on average.
constexpr double kModelLasts = 3;

Mixed mix(const std::array<MotionState, kMaxModels>& states, const std::array<double, kMaxModels>& weight,
          int count) {
  const Pose& middle = states[0].pose;
  std::array<Vec6, kMaxModels> xi;
  Vec6 mean = Vec6::Zero();
  Mixed result;
  for (std::size_t i = 0; i < std::size_t(count); ++i) {
    xi[i] = se3_log(middle.inverse() * states[i].pose);
    mean += weight[i] * xi[i];
    result.twist += weight[i] * states[i].twist;
  }
  result.pose = (middle * se3_exp(mean)).normalized();
  for (std::size_t i = 0; i < std::size_t(count); ++i) {
    const Vec6 apart = xi[i] - mean, twist_apart = states[i].twist - result.twist;
    result.covariance += weight[i] * (states[i].pp + apart * apart.transpose());
    result.twist_covariance += weight[i] * (states[i].tt + twist_apart * twist_apart.transpose());
  }
  return result;
}

}  // namespace

MotionBank::MotionBank(const TrackOptions& options) {
  /// Shares of the square of what the robot can do.
  struct Way {
    double walk, surge;
  };
  // The twist of what drives steadily (or stands) walks slowly; accelerations of wheels and of people's
  // pushes last some tenths of a second; what stops at a wall or jumps off walks by all it can.
  constexpr Way steady{1e-4, 0}, accelerated{0, 0.15}, sudden{1, 0}, able{0, 1};
  constexpr double kLasts = 0.4;  // seconds, of an acceleration
  std::vector<Way> ways;
  switch (options.prediction) {
    case Prediction::kAuto:
      ways = {steady, accelerated, sudden};
      break;
    case Prediction::kConstantTwist:
      ways = {steady, sudden};
      break;
    case Prediction::kConstantAcceleration:
      ways = {able};
      break;
    case Prediction::kNone:
      ways = {sudden};
      break;
  }
  const double turn2 = options.turn_acceleration * options.turn_acceleration;
  const double move2 = options.acceleration * options.acceleration;
  side_ = int(ways.size());
  for (const Way& turning : ways)
    for (const Way& moving : ways) {
      MotionModel& model = models_[std::size_t(count_++)];
      // An acceleration of variance s^2 that lasts for tau is a walk of the twist by 2 s^2 tau a second.
      model.walk << Vec3::Constant(turning.walk * turn2 * 2 * kLasts),
          Vec3::Constant(moving.walk * move2 * 2 * kLasts);
      model.surge << Vec3::Constant(turning.surge * turn2), Vec3::Constant(moving.surge * move2);
      model.acceleration_tau = kLasts;
    }
}

Kept MotionBank::start(const Measured& m, const Vec6& twist, const Mat6& twist_covariance) const {
  Kept kept;
  kept.measured = m;
  for (int i = 0; i < count_; ++i) {
    MotionState& state = kept.states[std::size_t(i)];
    state = start_motion(m.pose, m.noise, twist, twist_covariance, models_[std::size_t(i)]);
    if (m.twist) state = updated_by_twist(state, *m.twist, m.twist_variance);
    kept.weights[std::size_t(i)] = 1.0 / count_;
  }
  return kept;
}

Kept MotionBank::next(const Kept& before, const Measured& m) const {
  Kept kept;
  kept.measured = m;
  if (!m.has_pose) {
    kept.measured.noise = before.measured.noise;
    kept.measured.common = before.measured.common;
  }
  const double h = m.time - before.measured.time;
  const auto count = std::size_t(count_);
  const double stays = std::exp(-h / kModelLasts);
  const double leaves = side_ > 1 ? (1 - stays) / (side_ - 1) : 0;
  const auto side = std::size_t(side_);
  // Turning and moving change their ways each by itself.
  const auto passes = [&](std::size_t i, std::size_t j) {
    return (i / side == j / side ? stays : leaves) * (i % side == j % side ? stays : leaves);
  };
  double best = -1e300;
  for (std::size_t j = 0; j < count; ++j) {
    std::array<double, kMaxModels> from = {};
    double sum = 0;
    for (std::size_t i = 0; i < count; ++i)
      sum += from[i] = before.weights[i] * (count_ == 1 ? 1 : passes(i, j));
    for (std::size_t i = 0; i < count; ++i) from[i] /= sum;
    MotionState state =
        count_ == 1 ? before.states[0] : mixed(before.states.data(), from.data(), count_, models_[j]);
    state = advanced(state, h, models_[j]);
    const Innovation news =
        m.has_pose ? innovation(state, m.pose, m.noise) : twist_innovation(state, *m.twist, m.twist_variance);
    kept.weights[j] = std::log(sum) + news.log_likelihood;
    best = std::max(best, kept.weights[j]);
    if (m.has_pose) state = updated_by_pose(state, m.pose, m.noise);
    if (m.twist) state = updated_by_twist(state, *m.twist, m.twist_variance);
    kept.states[j] = state;
  }
  double sum = 0;
  // No model is given up for good.
  for (std::size_t j = 0; j < count; ++j)
    sum += kept.weights[j] = std::max(std::exp(kept.weights[j] - best), 1e-6);
  for (std::size_t j = 0; j < count; ++j) kept.weights[j] /= sum;
  if (!m.has_pose) kept.measured.pose = after(kept, 0).pose;
  return kept;
}

bool MotionBank::expects(const Kept& before, const Measured& m, double gate, double near_turn,
                         double near_move) const {
  const double h = m.time - before.measured.time;
  for (std::size_t i = 0; i < std::size_t(count_); ++i) {
    const Innovation seen_there = innovation(advanced(before.states[i], h, models_[i]), m.pose, m.noise);
    if (seen_there.chi2 < gate) return true;
    if (seen_there.xi.head<3>().norm() < near_turn && seen_there.xi.tail<3>().norm() < near_move) return true;
  }
  return false;
}

Mixed MotionBank::after(const Kept& kept, double seconds) const {
  if (seconds == 0) return mix(kept.states, kept.weights, count_);
  std::array<MotionState, kMaxModels> states;
  for (std::size_t i = 0; i < std::size_t(count_); ++i)
    states[i] = advanced(kept.states[i], seconds, models_[i]);
  return mix(states, kept.weights, count_);
}

}  // namespace procam::track::internal
