#pragma once
/// Where a child is by its odometry, between what a localiser and sights of known surfaces say: the filter of
/// pose_correction.hpp for messages that state a twist.
///
/// State: the pose X of the newest message, its error q = (w, d), true pose [exp(w) R_X, p_X + d], and the localiser's error
/// e of the same form, localised pose [exp(e_w) R, p + e_d] of the true one (the other sign than in pose_correction.hpp).
/// Both errors are in the axes of the world. From a message to the next, h seconds later, with the mean v of their twists:
///
///   X <- X exp(hat(h v)),   w <- w,   d <- d + w x (p_X' - p_X),   e <- phi e,   phi = exp(-h / tau),
///
/// with the noise of h v (of each twist, and of its scale) and of e (variance (1 - phi^2) s^2). To first order, the localiser
/// measures q + e and a sight q. Corrections move X and all earlier poses as one, so that the mean of q stays zero.
///
/// Source: error-state filters with a Gauss-Markov error of an aiding sensor: P. Maybeck, "Stochastic models, estimation, and
/// control", volume 1, 1979, sections 4.11 and 6.5.
#include <array>
#include <deque>

#include "procam/core/base/types.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::track::internal {

struct ReckonedMessage {
  double time = 0;
  Pose localised;
  Vec6 twist;
  Vec6 noise;  ///< variances of the localised pose that differ from message to message
};
struct ReckoningNoise {
  Vec6 localiser;          ///< variances of e: s^2
  double correlation = 0;  ///< tau, seconds
  Vec6 twist;              ///< variances of a message's twist
};

/// From standard deviations of the localiser's error and of a twist: [rotation, translation], metres and radians.
ReckoningNoise reckoning_noise(const Vec6& localiser_sigma, double correlation, double turn_sigma,
                               double speed_sigma);

/// Whether the twists tell the way: some drivers fill in zeros, or the twist by other axes. Compared are the ways of the last
/// second by the twists and by the localised poses, within six standard deviations and a tenth of the way. Allocates nothing.
class TwistCheck {
 public:
  explicit TwistCheck(const ReckoningNoise& noise) : noise_(noise) {}
  void add(const ReckonedMessage& message);
  /// The localiser has found another place: the way begins anew.
  void restart() { count_ = 0; }
  /// In the five seconds before the newest message.
  bool is_contradicted() const { return newest_.time < contradicted_until_; }
  /// Over half a second or more.
  bool agrees() const { return count_ > 0 && !is_contradicted() && newest_.time >= known_from_; }

 private:
  struct Moment {
    double time = 0;
    Pose localised, reckoned;
    Vec6 noise = Vec6::Zero(), noise_of_way = Vec6::Zero();
  };
  void keep(const Moment& moment);
  bool contradicts(const Moment& from) const;

  ReckoningNoise noise_;
  std::array<Moment, 12> kept_;  ///< a tenth of a second apart, the oldest first
  std::size_t count_ = 0;
  Moment newest_;
  Vec6 newest_twist_ = Vec6::Zero();
  double known_from_ = 0, contradicted_until_ = -1e300;
};

class DeadReckoning {
 public:
  DeadReckoning(const ReckoningNoise& noise, const ReckonedMessage& first);

  /// A message that is later than all before. False: the localised pose is farther away than all errors allow, chi-square of
  /// 6 degrees of freedom beyond `max_chi2`; only the twist was taken.
  bool add(const ReckonedMessage& message, double max_chi2);
  double time() const { return moments_.back().time; }
  /// The pose: between messages by their twists, and from the newest on by its own. Before the oldest that is kept, this one.
  Pose at(double time) const;
  /// Of q at that time.
  Mat6 covariance(double time) const;
  /// q of that time is known as `mean`, with the covariance `posterior` where it had covariance(time).
  void correct(double time, const Vec6& mean, const Mat6& posterior);
  /// e and its variances.
  const Vec6& localiser_error() const { return error_; }
  Vec6 localiser_variance() const { return covariance_.diagonal().tail<6>(); }

 private:
  using Mat12 = Eigen::Matrix<double, 12, 12>;
  struct Moment {
    double time;
    Pose pose;
    Vec6 twist;
  };

  const Pose& newest() const { return moments_.back().pose; }
  Mat6 from_newest(double time) const;
  Mat6 noise_of_way(const Moment& from, double seconds) const;
  void advance(double time, const Vec6& twist);
  void apply(const Eigen::Matrix<double, 12, 1>& step);

  ReckoningNoise noise_;
  std::deque<Moment> moments_;
  Vec6 error_ = Vec6::Zero();
  Mat12 covariance_;  ///< of (q, e) at the newest message
};

}  // namespace procam::track::internal
