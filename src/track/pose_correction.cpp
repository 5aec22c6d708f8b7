#include "procam/track/pose_correction.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "dead_reckoning.hpp"
#include "procam/core/base/error.hpp"

namespace procam::track {
namespace {

using internal::DeadReckoning;
using internal::ReckonedMessage;
using internal::ReckoningNoise;
using internal::TwistCheck;

/// chi-square of a localiser's pose, 6 degrees of freedom: 1 in 2 * 10^8.
constexpr double kMessageChi2 = 50;
/// Seconds without a message after which the odometry tells nothing of the way in between.
constexpr double kLongestGap = 1;

/// [exp(w) R, p + d].
Pose with_error(const Pose& pose, const Vec6& error) {
  return Pose(so3_exp(Vec3(error.head<3>())) * pose.rotation, pose.translation + error.tail<3>())
      .normalized();
}

ReckoningNoise noise_of(const PoseCorrectionOptions& options) {
  Vec6 sigma;
  sigma << options.tilt_sigma, options.tilt_sigma, options.rotation_sigma, options.position_sigma,
      options.position_sigma, options.height_sigma;
  return internal::reckoning_noise(sigma, options.correlation, options.track.turn_sigma,
                                   options.track.speed_sigma);
}

/// The left increment [w, d - w x p] of an error at p is of the same rotation about the world's origin.
Mat6 left_by_error(const Vec3& at) {
  Mat6 by = Mat6::Identity();
  by.bottomLeftCorner<3, 3>() = hat(at);
  return by;
}

}  // namespace

struct PoseCorrection::State {
  PoseCorrectionOptions options;
  PoseTrack localiser;
  ReckoningNoise noise;
  Vec6 error = Vec6::Zero();
  Mat6 covariance;
  double time = 0;  ///< of both; 0: no image has come
  double last_sight = -1e300;
  int refused_in_a_row = 0;
  TwistCheck twist_check;
  std::optional<DeadReckoning> reckoning;  ///< while the messages state a twist that can be believed
  int far_in_a_row = 0;                    ///< localised poses, by the reckoning
  PoseCorrectionStatus status;

  explicit State(const PoseCorrectionOptions& given)
      : options(given), localiser(given.track), noise(noise_of(given)), twist_check(noise) {
    for (const double positive : {given.position_sigma, given.rotation_sigma, given.height_sigma,
                                  given.tilt_sigma, given.correlation, given.max_chi2, given.alone_after})
      require(positive > 0 && std::isfinite(positive),
              "PoseCorrection: sigmas, times and max_chi2 must be positive");
    covariance = noise.localiser.asDiagonal();
  }

  /// Error and covariance at a time; of an earlier one those of the last image.
  std::pair<Vec6, Mat6> at(double when) const {
    const double phi = time > 0 ? std::exp(-std::max(0.0, when - time) / options.correlation) : 0;
    Mat6 later = phi * phi * covariance;
    later.diagonal() += (1 - phi * phi) * noise.localiser;
    return {phi * error, later};
  }

  StampedPose message(double when, const Pose& of_localiser, const Vec6& by, const Mat6& known) const {
    StampedPose result;
    result.arrival = when + options.track.delay;
    result.frame = localiser.frame();
    result.child = localiser.child();
    result.frame_from_child = with_error(of_localiser, by);
    const Mat6 left = left_by_error(result.frame_from_child.translation);
    result.covariance = left * known * left.transpose();
    return result;
  }

  bool take(const PoseSight& sight, const Pose& pose, Vec6& by, Mat6& known);
  bool reckon(const StampedPose& message, double when);
  StampedPose reckoned(const StampedPose& message, double when) const;
  void refuse();
};

/// Updates the pose's error and its covariance; false: refused.
bool PoseCorrection::State::take(const PoseSight& sight, const Pose& pose, Vec6& by, Mat6& known) {
  const auto increment = [&](const Vec6& e) {
    const Pose world_from_rig = with_error(pose, e) * options.child_from_rig;
    return se3_log(Pose(world_from_rig.inverse() * sight.world_from_rig));
  };
  const Vec6 start = increment(by);
  Mat6 jacobian;
  constexpr double kStep = 1e-5;
  for (int k = 0; k < 6; ++k) {
    const Vec6 step = kStep * Vec6::Unit(k);
    jacobian.col(k) = (increment(by + step) - increment(by - step)) / (2 * kStep);
  }
  const Mat6 information = jacobian.transpose() * sight.information * jacobian;
  const Vec6 score = jacobian.transpose() * (sight.score - sight.information * start);
  // The score b has the covariance A + A P A: A the information of the sight, P the covariance of the error before. A may be
  // singular (one bare wall). With P = L L^T and the eigenvalues a of L^T A L, the parts of L^T b along the eigenvectors have
  // the variances a + a^2; where a is 0 the sight says nothing.
  const Mat6 root = known.llt().matrixL();
  const Eigen::SelfAdjointEigenSolver<Mat6> seen(Mat6(root.transpose() * information * root));
  const Vec6 along = seen.eigenvectors().transpose() * (root.transpose() * score);
  double chi2 = 0;
  for (int k = 0; k < 6; ++k)
    if (const double a = seen.eigenvalues()[k]; a > 1e-6) chi2 += along[k] * along[k] / (a + a * a);
  status.chi2 = chi2;
  if (!(chi2 <= options.max_chi2)) return false;
  const Vec6 kept = (1 + seen.eigenvalues().cwiseMax(0).array()).inverse();
  const Mat6 axes = root * seen.eigenvectors();
  known = axes * kept.asDiagonal() * axes.transpose();
  by += known * score;
  return true;
}

/// The odometry up to a message. False: there is none that can be believed.
bool PoseCorrection::State::reckon(const StampedPose& message, double when) {
  if (!message.twist) {
    reckoning.reset();
    return false;
  }
  ReckonedMessage news{when, message.frame_from_child, *message.twist, localiser.noise().cwiseAbs2()};
  if (message.angular_rate) news.twist.head<3>() = *message.angular_rate;
  twist_check.add(news);
  if (!twist_check.agrees()) {
    reckoning.reset();
    return false;
  }
  if (reckoning && when > reckoning->time() && when - reckoning->time() < kLongestGap) {
    far_in_a_row = reckoning->add(news, kMessageChi2) ? 0 : far_in_a_row + 1;
    if (far_in_a_row < options.believe_after) return true;
  }
  // Also where the localiser has found another place.
  reckoning.emplace(noise, news);
  far_in_a_row = 0;
  return true;
}

/// Of a message's moment. While images come, they tell the pose, and the message its twist.
StampedPose PoseCorrection::State::reckoned(const StampedPose& from, double when) const {
  StampedPose result = message(when, reckoning->at(when), Vec6::Zero(), reckoning->covariance(when));
  result.twist = from.twist;
  result.angular_rate = from.angular_rate;
  if (when - last_sight < options.alone_after) result.covariance = kUnknownPoseVariance * Mat6::Identity();
  return result;
}

/// After some refused images the variances are those without any.
void PoseCorrection::State::refuse() {
  ++status.refused;
  if (++refused_in_a_row < options.believe_after) return;
  error.setZero();
  covariance = noise.localiser.asDiagonal();
  reckoning.reset();
}

PoseCorrection::PoseCorrection(const PoseCorrectionOptions& options)
    : state_(std::make_unique<State>(options)) {}
PoseCorrection::~PoseCorrection() = default;
PoseCorrection::PoseCorrection(PoseCorrection&&) noexcept = default;
PoseCorrection& PoseCorrection::operator=(PoseCorrection&&) noexcept = default;

std::optional<StampedPose> PoseCorrection::add(const StampedPose& message) {
  State& s = *state_;
  const double before = s.localiser.newest_time();
  // A twist is used where it agrees with the poses: the reckoning has it.
  StampedPose localised = message;
  if (message.twist) localised.twist.reset(), localised.angular_rate.reset();
  s.localiser.add(localised);
  const double when = s.localiser.newest_time();
  if (when == before) return std::nullopt;
  if (s.reckon(message, when)) return s.reckoned(message, when);
  if (when - s.last_sight < s.options.alone_after) return std::nullopt;
  const TrackedPose pose = s.localiser.at(when);
  const auto [by, known] = s.at(when);
  StampedPose result = s.message(when, pose.frame_from_child, by, known);
  if (message.twist && s.twist_check.is_contradicted()) return result;
  result.twist = message.twist;
  result.angular_rate = message.angular_rate;
  return result;
}

std::optional<StampedPose> PoseCorrection::add(const PoseSight& sight) {
  State& s = *state_;
  const TrackedPose localised = s.localiser.at(sight.time);
  if (localised.state == TrackState::kNone) return std::nullopt;
  const Pose pose = s.reckoning ? s.reckoning->at(sight.time) : localised.frame_from_child;
  auto [by, known] =
      s.reckoning ? std::pair(Vec6(Vec6::Zero()), s.reckoning->covariance(sight.time)) : s.at(sight.time);
  if (!s.take(sight, pose, by, known)) {
    s.refuse();
    return std::nullopt;
  }
  s.refused_in_a_row = 0;
  s.last_sight = sight.time;
  ++s.status.taken;
  s.status.time = sight.time;
  if (s.reckoning) {
    s.reckoning->correct(sight.time, by, known);
    s.status.error = -s.reckoning->localiser_error();
    s.status.sigma = s.reckoning->localiser_variance().cwiseMax(0).cwiseSqrt();
  } else {
    s.error = by;
    s.covariance = known;
    s.time = sight.time;
    s.status.error = by;
    s.status.sigma = known.diagonal().cwiseMax(0).cwiseSqrt();
  }
  return s.message(sight.time, pose, by, known);
}

std::optional<StampedPose> PoseCorrection::add(const std::vector<PoseSight>& sights) {
  std::optional<StampedPose> newest;
  for (const PoseSight& sight : sights)
    if (auto pose = add(sight)) newest = std::move(pose);
  return newest;
}

PoseCorrectionStatus PoseCorrection::status() const {
  return state_->status;
}

}  // namespace procam::track
