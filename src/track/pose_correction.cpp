#include "procam/track/pose_correction.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "procam/core/base/error.hpp"

namespace procam::track {
namespace {

/// [exp(w) R, p + d].
Pose with_error(const Pose& pose, const Vec6& error) {
  return Pose(so3_exp(Vec3(error.head<3>())) * pose.rotation, pose.translation + error.tail<3>())
      .normalized();
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
  Vec6 usual;  ///< variances without any image
  Vec6 error = Vec6::Zero();
  Mat6 covariance;
  double time = 0;  ///< of both; 0: no image has come
  double last_sight = -1e300;
  int refused_in_a_row = 0;
  PoseCorrectionStatus status;

  explicit State(const PoseCorrectionOptions& given) : options(given), localiser(given.track) {
    for (const double positive : {given.position_sigma, given.rotation_sigma, given.height_sigma,
                                  given.tilt_sigma, given.correlation, given.max_chi2, given.alone_after})
      require(positive > 0 && std::isfinite(positive),
              "PoseCorrection: sigmas, times and max_chi2 must be positive");
    usual << given.tilt_sigma, given.tilt_sigma, given.rotation_sigma, given.position_sigma,
        given.position_sigma, given.height_sigma;
    usual = usual.cwiseAbs2().eval();
    covariance = usual.asDiagonal();
  }

  /// Error and covariance at a time; of an earlier one those of the last image.
  std::pair<Vec6, Mat6> at(double when) const {
    const double phi = time > 0 ? std::exp(-std::max(0.0, when - time) / options.correlation) : 0;
    Mat6 later = phi * phi * covariance;
    later.diagonal() += (1 - phi * phi) * usual;
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

  bool take(const PoseSight& sight, const Pose& of_localiser, Vec6& by, Mat6& known);
};

/// Updates error and covariance; false: refused.
bool PoseCorrection::State::take(const PoseSight& sight, const Pose& of_localiser, Vec6& by, Mat6& known) {
  const auto increment = [&](const Vec6& e) {
    const Pose world_from_rig = with_error(of_localiser, e) * options.child_from_rig;
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

PoseCorrection::PoseCorrection(const PoseCorrectionOptions& options)
    : state_(std::make_unique<State>(options)) {}
PoseCorrection::~PoseCorrection() = default;
PoseCorrection::PoseCorrection(PoseCorrection&&) noexcept = default;
PoseCorrection& PoseCorrection::operator=(PoseCorrection&&) noexcept = default;

std::optional<StampedPose> PoseCorrection::add(const StampedPose& message) {
  State& s = *state_;
  const double before = s.localiser.newest_time();
  s.localiser.add(message);
  const double when = s.localiser.newest_time();
  if (when == before || when - s.last_sight < s.options.alone_after) return std::nullopt;
  const TrackedPose pose = s.localiser.at(when);
  const auto [by, known] = s.at(when);
  StampedPose result = s.message(when, pose.frame_from_child, by, known);
  result.twist = message.twist;
  result.angular_rate = message.angular_rate;
  return result;
}

std::optional<StampedPose> PoseCorrection::add(const PoseSight& sight) {
  State& s = *state_;
  const TrackedPose pose = s.localiser.at(sight.time);
  if (pose.state == TrackState::kNone) return std::nullopt;
  auto [by, known] = s.at(sight.time);
  if (!s.take(sight, pose.frame_from_child, by, known)) {
    ++s.status.refused;
    if (++s.refused_in_a_row >= s.options.believe_after) {
      s.error.setZero();
      s.covariance = s.usual.asDiagonal();
    }
    return std::nullopt;
  }
  s.refused_in_a_row = 0;
  s.error = by;
  s.covariance = known;
  s.time = s.last_sight = sight.time;
  ++s.status.taken;
  s.status.error = by;
  s.status.sigma = known.diagonal().cwiseMax(0).cwiseSqrt();
  s.status.time = sight.time;
  return s.message(sight.time, pose.frame_from_child, by, known);
}

PoseCorrectionStatus PoseCorrection::status() const {
  return state_->status;
}

}  // namespace procam::track
