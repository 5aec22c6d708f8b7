#pragma once
/// The solve of update.hpp.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "rig_parameters.hpp"
#include "solve.hpp"

namespace procam::calibrate {

/// The maximum of the posterior, by Gauss-Newton with the boards' poses eliminated.
class UpdateSolve {
 public:
  UpdateSolve(const Correspondences& data, const RigParameters& all, const UpdateOptions& options,
              const Rig& rig);

  void solve();

  int count_used() const {
    return int(
        std::count_if(notes_.begin(), notes_.end(), [](const std::string& note) { return note.empty(); }));
  }
  bool any_used() const { return count_used() > 0; }
  /// More than half of the views that could be used at the start.
  bool most_agree() const;
  bool all_used() const { return count_used() == usable_; }

  const BundleState& state() const { return state_; }
  const UsedMask& used() const { return used_; }
  const std::vector<std::string>& notes() const { return notes_; }
  /// Of the start's prior and the views together.
  MatX covariance() const { return *scaled_inverse(information()); }
  /// (theta - theta_0)^T (P + Q)^-1 (theta - theta_0)
  double prior_cost() const {
    const VecX d = all_.difference(state_);
    return d.dot(prior_ * d);
  }
  double cost() const { return cost_of(state_); }

  /// The change itself, and its covariance: with K = Q (P + Q)^-1 and C the covariance of theta,
  ///   q = K (theta - theta_0),   cov(q) = K P + K C K^T
  /// K P = Q - K Q without the difference of large numbers.
  std::pair<VecX, MatX> change() const {
    const MatX gain = variance_ * prior_;
    const MatX known = gain * all_.covariance();
    return {gain * all_.difference(state_),
            0.5 * (known + known.transpose()) + gain * covariance() * gain.transpose()};
  }

  /// Sigma of a device's fx over fx, if `also` had changed too.
  double focal_sigma_with(const RigChange& also, std::size_t device) const;

 private:
  void leave_out(std::size_t view, const std::string& why) {
    for (auto& of_device : used_[view]) std::fill(of_device.begin(), of_device.end(), char(0));
    notes_[view] = why;
  }

  /// Each board by the first camera that sees enough of it.
  void pose_boards();

  /// Residuals as long as the first calibration left them: the views' own would hide a contradiction.
  void set_noise(const Rig& rig);

  /// Board poses that fit a state's devices best.
  BundleState with_boards(const BundleState& state) const {
    return bundle_adjust(data_, used_, state, hold_devices(bundle_, state)).state;
  }

  double cost_of(const BundleState& state) const;

  struct Equations {
    MatX information;  ///< of prior and views
    VecX gradient;
  };
  Equations equations() const;
  MatX information() const { return equations().information; }

  void converge();

  /// How a view's points of one device agree with the state; marks those within the limit as used.
  struct Agreement {
    int count = 0, within = 0;
    double squared_px = 0;      ///< over all points
    double squared_sigmas = 0;  ///< over the points within, two components each
    bool changed = false;       ///< a point was rejected, or accepted again

    bool contradicts() const;
  };
  Agreement judge_points(std::size_t v, std::size_t d);

  /// Points beyond the outlier limit, and views that contradict the rig in one device. True when anything changed.
  bool reject();

  const Correspondences& data_;
  const RigParameters& all_;
  const UpdateOptions& options_;
  UsedMask used_;
  BundleState state_;
  BundleOptions bundle_;
  MatX variance_, prior_;           ///< Q, (P + Q)^-1
  std::vector<std::string> notes_;  ///< by view: why it was rejected
  int usable_ = 0;                  ///< views with enough of the board
};

}  // namespace procam::calibrate
