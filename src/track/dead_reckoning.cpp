#include "dead_reckoning.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace procam::track::internal {
namespace {

constexpr double kKept = 2;  // seconds of earlier poses: sights may be so late
/// Wheels of another diameter, and a floor on which they slip: a share of the twist, the same for about a second.
constexpr double kScale = 0.03, kScaleLasts = 1;

template <typename Matrix>
void make_symmetric(Matrix& m) {
  m = (0.5 * (m + m.transpose())).eval();
}

}  // namespace

ReckoningNoise reckoning_noise(const Vec6& localiser_sigma, double correlation, double turn_sigma,
                               double speed_sigma) {
  Vec6 twist;
  twist << Vec3::Constant(turn_sigma), Vec3::Constant(speed_sigma);
  return {localiser_sigma.cwiseAbs2(), correlation, twist.cwiseAbs2()};
}

void TwistCheck::keep(const Moment& moment) {
  if (count_ == kept_.size()) std::rotate(kept_.begin(), kept_.begin() + 1, kept_.end());
  count_ = std::min(count_ + 1, kept_.size());
  kept_[count_ - 1] = moment;
}

void TwistCheck::add(const ReckonedMessage& message) {
  constexpr double kOver = 1, kApart = 0.1, kFirst = 0.5, kDistrusted = 5;  // seconds
  const double h = message.time - newest_.time;
  Moment now{message.time, message.localised, newest_.reckoned, message.noise, newest_.noise_of_way};
  if (count_ == 0 || h <= 0 || h > kOver) {
    count_ = 0;
    known_from_ = message.time + kFirst;
  } else {
    now.reckoned = (now.reckoned * se3_exp(Vec6(0.5 * h * (newest_twist_ + message.twist)))).normalized();
    now.noise_of_way += h * h * noise_.twist;
  }
  newest_ = now;
  newest_twist_ = message.twist;
  if (count_ == 0 || now.time - kept_[count_ - 1].time >= kApart) keep(now);
  const auto from = std::find_if(kept_.begin(), kept_.begin() + std::ptrdiff_t(count_),
                                 [&](const Moment& one) { return one.time >= now.time - kOver; });
  if (contradicts(*from)) contradicted_until_ = now.time + kDistrusted;
}

bool TwistCheck::contradicts(const Moment& from) const {
  constexpr double kLimit = 6, kShare = 0.1;
  const Pose way = from.reckoned.inverse() * newest_.reckoned;
  const double phi = std::exp(-(newest_.time - from.time) / noise_.correlation);
  const Vec6 variance = from.noise + newest_.noise + newest_.noise_of_way - from.noise_of_way +
                        2 * (1 - phi) * noise_.localiser;
  const Pose localised = from.localised.inverse() * newest_.localised;
  const Vec6 off = se3_log(Pose(way.inverse() * localised));
  // Where the way ends, an error of the first heading counts by its length.
  const double turn = so3_log(localised.rotation).norm(), length = localised.translation.norm();
  const double of_turn = variance.head<3>().maxCoeff(),
               of_place = variance.tail<3>().maxCoeff() +
                          length * length * (of_turn + noise_.localiser.head<3>().maxCoeff());
  const auto beyond = [&](double error, double one_variance, double whole) {
    return error > kLimit * std::sqrt(one_variance) + kShare * whole;
  };
  return beyond(off.head<3>().norm(), of_turn, turn) || beyond(off.tail<3>().norm(), of_place, length);
}

DeadReckoning::DeadReckoning(const ReckoningNoise& noise, const ReckonedMessage& first)
    : noise_(noise), moments_{{first.time, first.localised.normalized(), first.twist}} {
  const Mat6 prior = noise.localiser.asDiagonal();
  covariance_ << prior + Mat6(first.noise.asDiagonal()), -prior, -prior, prior;
}

/// Of h v as part of q, by the axes of the world. An error b that lasts for T, short beside the drive, is a walk of
/// variance 2 b^2 T a second.
Mat6 DeadReckoning::noise_of_way(const Moment& from, double seconds) const {
  const Mat3 axes = from.pose.rotation.toRotationMatrix();
  const Vec6 variance = seconds * seconds * noise_.twist;
  const double of_scale = 2 * kScale * kScale * kScaleLasts * seconds;
  Mat6 noise = Mat6::Zero();
  noise.topLeftCorner<3, 3>() = axes * variance.head<3>().asDiagonal() * axes.transpose();
  noise.bottomRightCorner<3, 3>() = axes * variance.tail<3>().asDiagonal() * axes.transpose();
  noise.diagonal().head<3>().array() += of_scale * from.twist.head<3>().squaredNorm();
  noise.diagonal().tail<3>().array() += of_scale * from.twist.tail<3>().squaredNorm();
  return noise;
}

void DeadReckoning::advance(double time, const Vec6& twist) {
  const Moment& last = moments_.back();
  const double h = time - last.time;
  const Pose pose = (last.pose * se3_exp(Vec6(0.5 * h * (last.twist + twist)))).normalized();
  const double phi = std::exp(-h / noise_.correlation);
  Mat12 by = Mat12::Identity();
  by.block<3, 3>(3, 0) = -hat(Vec3(pose.translation - last.pose.translation));
  by.bottomRightCorner<6, 6>() *= phi;
  covariance_ = by * covariance_ * by.transpose();
  covariance_.topLeftCorner<6, 6>() += noise_of_way({time, pose, twist}, h);
  covariance_.diagonal().tail<6>() += (1 - phi * phi) * noise_.localiser;
  error_ *= phi;
  moments_.push_back({time, pose, twist});
  while (moments_.front().time < time - kKept) moments_.pop_front();
}

bool DeadReckoning::add(const ReckonedMessage& message, double max_chi2) {
  advance(message.time, message.twist);
  Vec6 off;
  off << so3_log(message.localised.rotation * newest().rotation.conjugate()),
      message.localised.translation - newest().translation;
  off -= error_;
  const Eigen::Matrix<double, 12, 6> cross = covariance_.leftCols<6>() + covariance_.rightCols<6>();
  const Mat6 sum = cross.topRows<6>() + cross.bottomRows<6>() + Mat6(message.noise.asDiagonal());
  const Eigen::LDLT<Mat6> solver(sum);
  if (!(off.dot(solver.solve(off)) <= max_chi2)) return false;
  const Eigen::Matrix<double, 12, 6> gain = solver.solve(cross.transpose()).transpose();
  covariance_ -= gain * cross.transpose();
  make_symmetric(covariance_);
  apply(gain * off);
  return true;
}

/// Moves the poses by the mean that q has now, about the newest place, and e.
void DeadReckoning::apply(const Eigen::Matrix<double, 12, 1>& step) {
  const Vec3 about = newest().translation;
  const Eigen::Quaterniond turn = so3_exp(Vec3(step.head<3>()));
  for (Moment& moment : moments_)
    moment.pose = Pose(turn * moment.pose.rotation,
                       about + step.segment<3>(3) + turn * Vec3(moment.pose.translation - about))
                      .normalized();
  error_ += step.tail<6>();
}

Pose DeadReckoning::at(double time) const {
  std::size_t after = moments_.size() - 1;
  while (after > 0 && moments_[after - 1].time > time) --after;
  const Moment& to = moments_[after];
  if (time >= to.time) return to.pose * se3_exp(Vec6((time - to.time) * to.twist));
  if (after == 0) return to.pose;
  // The twist changes evenly from message to message.
  const Moment& from = moments_[after - 1];
  const double h = time - from.time, whole = to.time - from.time;
  return from.pose * se3_exp(Vec6(h * from.twist + 0.5 * h * h / whole * (to.twist - from.twist)));
}

/// q of that time by q of the newest message: both move as one.
Mat6 DeadReckoning::from_newest(double time) const {
  Mat6 by = Mat6::Identity();
  by.bottomLeftCorner<3, 3>() = hat(Vec3(newest().translation - at(time).translation));
  return by;
}

Mat6 DeadReckoning::covariance(double time) const {
  const Mat6 by = from_newest(time);
  Mat6 result = by * covariance_.topLeftCorner<6, 6>() * by.transpose();
  if (time > this->time()) result += noise_of_way(moments_.back(), time - this->time());
  return result;
}

void DeadReckoning::correct(double time, const Vec6& mean, const Mat6& posterior) {
  const Mat6 prior = covariance(time);
  const Eigen::Matrix<double, 12, 6> cross = covariance_.leftCols<6>() * from_newest(time).transpose();
  const Eigen::Matrix<double, 12, 6> gain = Eigen::LDLT<Mat6>(prior).solve(cross.transpose()).transpose();
  covariance_ -= gain * (prior - posterior) * gain.transpose();
  make_symmetric(covariance_);
  apply(gain * mean);
}

}  // namespace procam::track::internal
