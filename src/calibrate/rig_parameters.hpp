#pragma once
/// All free parameters of a calibrated rig as one vector, with their covariance, and what a change adds to it.
#include <optional>
#include <string>
#include <vector>

#include "procam/calibrate/bundle.hpp"
#include "procam/calibrate/update.hpp"

namespace procam::calibrate {

/// The views' observations with all devices of the rig, in its order; a device that no view shows has none. Throws
/// Error(kInput) for a device that the rig lacks.
Correspondences of_whole_rig(const Rig& rig, const Correspondences& views);

/// The rig as a bundle starts from it; boards have no pose yet.
BundleState state_of(const Rig& rig, const Correspondences& data);

/// All free parameters of the rig as one vector, whether views show their devices or not.
class RigParameters {
 public:
  RigParameters(const Rig& rig, const Correspondences& data, BundleState start);

  int size() const { return int(names_.size()); }
  const std::vector<std::string>& names() const { return names_; }
  const MatX& covariance() const { return covariance_; }
  const BundleState& start() const { return start_; }
  const std::vector<std::vector<std::string>>& held() const { return held_; }
  bool holds_pose(std::size_t d) const { return pose_at_[d] < 0; }
  int pose_at(std::size_t d) const { return pose_at_[d]; }
  std::optional<int> lens_at(std::size_t d, const std::string& parameter) const {
    const std::vector<std::string> all = parameter_names(start_.lenses[d]);
    for (std::size_t i = 0; i < lenses_[d].size(); ++i)
      if (all[std::size_t(lenses_[d][i])] == parameter) return lens_at_[d] + int(i);
    return std::nullopt;
  }

  BundleState moved(const BundleState& state, const VecX& step) const;

  /// The state's parameters minus the start's.
  VecX difference(const BundleState& state) const;

 private:
  BundleState start_;
  std::vector<std::string> names_;
  std::vector<std::vector<int>> lenses_;  ///< by device: positions of the free ones in parameters_of(lens)
  std::vector<std::vector<std::string>> held_;
  std::vector<int> lens_at_, pose_at_;  ///< by device: first row; -1: held
  MatX covariance_;
};

/// The device's number. Throws Error(kInput) for a name that the rig lacks.
std::size_t device_of(const Correspondences& data, const RigChange& change);

/// Q: what the changes add to the covariance of the parameters.
MatX variance_of(const std::vector<RigChange>& changes, const Correspondences& data,
                 const RigParameters& all);

/// The inverse of a covariance whose parameters differ by many powers of ten; nullopt unless it is positive definite.
std::optional<MatX> scaled_inverse(const MatX& covariance);

}  // namespace procam::calibrate
