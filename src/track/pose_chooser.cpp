#include "procam/track/pose_chooser.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "pose_filter.hpp"
#include "procam/core/base/error.hpp"

namespace procam::track {
namespace {

using internal::MotionModel;
using internal::MotionState;

constexpr std::size_t kMaxHypotheses = 4;
/// Log likelihood of a step that no hypothesis expects: an image that is wrong ends none of them.
constexpr double kMinFit = -25;
/// Twists that differ by less are one motion: rad/s, m/s.
constexpr double kSameTurn = 0.1, kSameSpeed = 0.1;
/// Variance of the twist of a plane that is seen for the first time: (1 rad/s)^2, (0.5 m/s)^2.
constexpr double kFirstTurn2 = 1, kFirstSpeed2 = 0.25;
/// Seconds for which an acceleration lasts (motion_bank.cpp).
constexpr double kLasts = 0.4;

struct Hypothesis {
  MotionState state;
  std::size_t candidate = 0;  ///< of the last image
  double log_weight = 0;
};

/// The covariance of the right increment, in the frame of the plane.
Mat6 in_plane(const PoseWithCovariance& pose) {
  const Mat6 into_plane = adjoint(pose.pose.inverse());
  Mat6 covariance = into_plane * pose.covariance * into_plane.transpose();
  covariance.diagonal().array() += 1e-10;  // an exact pose has a density, too
  return covariance;
}

double half_log_determinant(const Mat6& covariance) {
  const Eigen::LLT<Mat6> cholesky(covariance);
  return Mat6(cholesky.matrixL()).diagonal().array().log().sum();
}

bool are_one(const Hypothesis& a, const Hypothesis& b) {
  const Vec6 apart = a.state.twist - b.state.twist;
  return a.candidate == b.candidate && apart.head<3>().norm() < kSameTurn &&
         apart.tail<3>().norm() < kSameSpeed;
}

double log_of_sum(double a, double b) {
  return std::max(a, b) + std::log1p(std::exp(-std::abs(a - b)));
}

/// The most probable ones, those that are one joined; their weights sum to 1.
std::vector<Hypothesis> pruned(std::vector<Hypothesis> all) {
  std::sort(all.begin(), all.end(),
            [](const Hypothesis& a, const Hypothesis& b) { return a.log_weight > b.log_weight; });
  std::vector<Hypothesis> kept;
  for (const Hypothesis& one : all) {
    const auto same =
        std::find_if(kept.begin(), kept.end(), [&](const Hypothesis& k) { return are_one(k, one); });
    if (same != kept.end())
      same->log_weight = log_of_sum(same->log_weight, one.log_weight);
    else if (kept.size() < kMaxHypotheses)
      kept.push_back(one);
  }
  double sum = kept.front().log_weight;
  for (std::size_t i = 1; i < kept.size(); ++i) sum = log_of_sum(sum, kept[i].log_weight);
  for (Hypothesis& one : kept) one.log_weight -= sum;
  return kept;
}

}  // namespace

struct PoseChooser::State {
  PoseChooserOptions options;
  MotionModel model;
  std::vector<Hypothesis> hypotheses;
  double time = 0;

  double evidence(const PoseCandidate& candidate) const {
    return std::min(candidate.chi2, options.max_evidence);
  }

  std::vector<Hypothesis> first(const std::vector<PoseCandidate>& candidates) const {
    Vec6 twist2;
    twist2 << Vec3::Constant(kFirstTurn2), Vec3::Constant(kFirstSpeed2);
    std::vector<Hypothesis> all;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      const Mat6 noise = in_plane(candidates[c].pose);
      all.push_back({internal::start_motion(candidates[c].pose.pose, noise, Vec6::Zero(),
                                            Mat6(twist2.asDiagonal()), model),
                     c, -0.5 * evidence(candidates[c]) + half_log_determinant(noise)});
    }
    return all;
  }

  std::vector<Hypothesis> next(double seconds, const std::vector<PoseCandidate>& candidates) const {
    const double share = std::min(1.0, seconds / options.independent_after);
    std::vector<Hypothesis> all;
    for (const Hypothesis& before : hypotheses) {
      const MotionState ahead = internal::advanced(before.state, seconds, model);
      for (std::size_t c = 0; c < candidates.size(); ++c) {
        const Mat6 noise = in_plane(candidates[c].pose);
        const double fit = internal::innovation(ahead, candidates[c].pose.pose, noise).log_likelihood +
                           half_log_determinant(noise);
        // A step that is not expected says nothing of the motion before it.
        const bool goes_on = fit > kMinFit;
        all.push_back({goes_on ? internal::updated_by_pose(ahead, candidates[c].pose.pose, noise)
                               : first({candidates[c]}).front().state,
                       c,
                       before.log_weight + std::max(fit, kMinFit) - 0.5 * share * evidence(candidates[c])});
      }
    }
    return all;
  }
};

PoseChooser::PoseChooser(const PoseChooserOptions& options) : state_(std::make_unique<State>()) {
  require(options.forget_after > 0 && options.max_evidence > 0 && options.independent_after > 0 &&
              options.acceleration > 0 && options.turn_acceleration > 0,
          "PoseChooser: times and accelerations must be positive");
  state_->options = options;
  state_->model.walk << Vec3::Constant(2 * kLasts * options.turn_acceleration * options.turn_acceleration),
      Vec3::Constant(2 * kLasts * options.acceleration * options.acceleration);
}
PoseChooser::~PoseChooser() = default;
PoseChooser::PoseChooser(PoseChooser&&) noexcept = default;
PoseChooser& PoseChooser::operator=(PoseChooser&&) noexcept = default;

ChosenPose PoseChooser::choose(double time, const std::vector<PoseCandidate>& candidates) {
  require(!candidates.empty(), "PoseChooser: an image without a candidate");
  State& s = *state_;
  const double seconds = time - s.time;
  const bool goes_on = !s.hypotheses.empty() && seconds > 0 && seconds <= s.options.forget_after;
  s.hypotheses = pruned(goes_on ? s.next(seconds, candidates) : s.first(candidates));
  s.time = time;
  std::vector<double> probability(candidates.size(), 0.0);
  for (const Hypothesis& one : s.hypotheses) probability[one.candidate] += std::exp(one.log_weight);
  const auto best = std::max_element(probability.begin(), probability.end());
  ChosenPose chosen;
  chosen.index = std::size_t(best - probability.begin());
  for (std::size_t c = 0; c < probability.size(); ++c)
    if (c != chosen.index) chosen.odds += probability[c];
  return chosen;
}

}  // namespace procam::track
