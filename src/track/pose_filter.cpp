#include "pose_filter.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace procam::track::internal {
namespace {

/// The noise of a step is that of short steps: of longer ones several are made.
constexpr double kLongestStep = 0.05;

Mat6 symmetric(const Mat6& m) {
  return 0.5 * (m + m.transpose());
}

MotionState step(const MotionState& s, double h, const MotionModel& model) {
  // Integrals of an acceleration that fades: of a once (k1) and twice (k2) over the step.
  const double x = h / model.acceleration_tau, kept = std::exp(-x);
  const double k1 = model.acceleration_tau * -std::expm1(-x), k2 = model.acceleration_tau * (h - k1);
  const Vec6 increment = s.twist * h + s.rate * k2;
  const Pose after_from_before = se3_exp(Vec6(-increment));
  const Mat6 ad = adjoint(after_from_before);

  MotionState n;
  n.pose = (s.pose * se3_exp(increment)).normalized();
  n.twist = s.twist + k1 * s.rate;
  n.rate = kept * s.rate;

  const Mat6 ad_pt = ad * s.pt, ad_pr = ad * s.pr;
  const Mat6 pose_rate = ad_pr + h * s.tr + k2 * s.rr;  // E[xi' da^T] before the fading
  const Mat6 cross = h * ad_pt + k2 * ad_pr + (h * k2) * s.tr;
  n.pp = ad * s.pp * ad.transpose();
  n.pp += cross + cross.transpose() + (h * h) * s.tt + (k2 * k2) * s.rr;
  n.pt = ad_pt + h * s.tt + k2 * s.tr.transpose() + k1 * pose_rate;
  n.pr = kept * pose_rate;
  n.tt = s.tt + k1 * (s.tr + s.tr.transpose()) + (k1 * k1) * s.rr;
  n.tr = kept * (s.tr + k1 * s.rr);
  n.rr = (kept * kept) * s.rr;

  const Vec6 walk = model.walk;
  n.pp.diagonal() += walk * (h * h * h / 3);
  n.pt.diagonal() += walk * (h * h / 2);
  n.tt.diagonal() += walk * h;
  const Vec6 jerk =
      model.surge * (2 / model.acceleration_tau);  // so that the acceleration's variance stays `surge`
  const double h2 = h * h, h3 = h2 * h;
  n.pp.diagonal() += jerk * (h3 * h2 / 20);
  n.pt.diagonal() += jerk * (h2 * h2 / 8);
  n.pr.diagonal() += jerk * (h3 / 6);
  n.tt.diagonal() += jerk * (h3 / 3);
  n.tr.diagonal() += jerk * (h2 / 2);
  n.rr.diagonal() += jerk * h;
  return n;
}

/// After a measurement with covariance `s` of its innovation; p, t, r are the covariances of pose, twist and
/// rate with what was measured.
MotionState updated(const MotionState& state, const Vec6& xi, const Mat6& s, const Mat6& p, const Mat6& t,
                    const Mat6& r) {
  const Eigen::LLT<Mat6> solver(s);
  const Mat6 inverse = solver.solve(Mat6::Identity());
  const Mat6 gain_p = p * inverse, gain_t = t * inverse, gain_r = r * inverse;
  MotionState n;
  n.pose = (state.pose * se3_exp(Vec6(gain_p * xi))).normalized();
  n.twist = state.twist + gain_t * xi;
  n.rate = state.rate + gain_r * xi;
  n.pp = symmetric(state.pp - gain_p * p.transpose());
  n.pt = state.pt - gain_p * t.transpose();
  n.pr = state.pr - gain_p * r.transpose();
  n.tt = symmetric(state.tt - gain_t * t.transpose());
  n.tr = state.tr - gain_t * r.transpose();
  n.rr = symmetric(state.rr - gain_r * r.transpose());
  return n;
}

Innovation surprise(const Vec6& xi, const Mat6& covariance) {
  Innovation result;
  result.xi = xi;
  const Eigen::LLT<Mat6> solver(covariance);
  const Vec6 white = solver.matrixL().solve(xi);
  result.chi2 = white.squaredNorm();
  result.log_likelihood = -0.5 * result.chi2 - Mat6(solver.matrixL()).diagonal().array().log().sum();
  return result;
}

}  // namespace

MotionState start_motion(const Pose& measured, const Mat6& noise, const Vec6& twist,
                         const Mat6& twist_covariance, const MotionModel& model) {
  MotionState state;
  state.pose = measured;
  state.twist = twist;
  state.pp = noise;
  state.tt = twist_covariance;
  state.rr = model.surge.asDiagonal();
  state.pt.setZero();
  state.pr.setZero();
  state.tr.setZero();
  return state;
}

MotionState advanced(const MotionState& state, double seconds, const MotionModel& model) {
  if (!(seconds > 0)) return state;
  const int steps = int(std::min(std::ceil(seconds / kLongestStep), 40.0));
  MotionState now = state;
  for (int i = 0; i < steps; ++i) now = step(now, seconds / steps, model);
  return now;
}

MotionState mixed(const MotionState* states, const double* weights, int count, const MotionModel& model) {
  const Pose middle_from_frame = states[0].pose.inverse();
  Vec6 pose_mean = Vec6::Zero();
  MotionState result;
  for (int i = 0; i < count; ++i) {
    pose_mean += weights[i] * se3_log(middle_from_frame * states[i].pose);
    result.twist += weights[i] * states[i].twist;
    result.rate += weights[i] * states[i].rate;
  }
  result.pose = (states[0].pose * se3_exp(pose_mean)).normalized();
  for (Mat6* block : {&result.pp, &result.pt, &result.pr, &result.tt, &result.tr, &result.rr})
    block->setZero();
  for (int i = 0; i < count; ++i) {
    const MotionState& s = states[i];
    const double w = weights[i];
    const Vec6 p = se3_log(middle_from_frame * s.pose) - pose_mean;
    const Vec6 t = s.twist - result.twist;
    const Vec6 r = s.rate - result.rate;
    result.pp += w * (s.pp + p * p.transpose());
    result.pt += w * (s.pt + p * t.transpose());
    result.tt += w * (s.tt + t * t.transpose());
    result.pr += w * (s.pr + p * r.transpose());
    result.tr += w * (s.tr + t * r.transpose());
    result.rr += w * (s.rr + r * r.transpose());
    for (Eigen::Index k = 0; k < 6; ++k)
      if (s.rr(k, k) == 0) result.rr(k, k) += w * model.surge[k];
  }
  for (Eigen::Index k = 0; k < 6; ++k) {
    if (model.surge[k] > 0) continue;
    result.rate[k] = 0;
    result.pr.col(k).setZero();
    result.tr.col(k).setZero();
    result.rr.col(k).setZero();
    result.rr.row(k).setZero();
  }
  return result;
}

Innovation innovation(const MotionState& state, const Pose& measured, const Mat6& noise) {
  return surprise(se3_log(state.pose.inverse() * measured), state.pp + noise);
}

Innovation twist_innovation(const MotionState& state, const Vec6& twist, const Vec6& variance) {
  return surprise(twist - state.twist, state.tt + Mat6(variance.asDiagonal()));
}

MotionState updated_by_pose(const MotionState& state, const Pose& measured, const Mat6& noise) {
  const Vec6 xi = se3_log(state.pose.inverse() * measured);
  return updated(state, xi, state.pp + noise, state.pp, state.pt.transpose(), state.pr.transpose());
}

MotionState updated_by_twist(const MotionState& state, const Vec6& twist, const Vec6& variance) {
  const Mat6 s = state.tt + Mat6(variance.asDiagonal());
  return updated(state, twist - state.twist, s, state.pt, state.tt, state.tr.transpose());
}

}  // namespace procam::track::internal
