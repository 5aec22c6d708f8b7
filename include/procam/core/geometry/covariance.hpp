#pragma once
/// Uncertainty that travels: poses with a 6x6 covariance, and covariances whose rows have names.
///
/// The increment is on the left, order [rotation, translation]: target_from_source = se3_exp(xi) * mean, xi ~
/// N(0, C). To first order (Barfoot, "State Estimation for Robotics", 2017, section 7.3):
///   c_from_a = c_from_b b_from_a:  C_ca = C_cb + Ad(c_from_b) C_ba Ad^T
///   source_from_target = inverse:  C_st = Ad(source_from_target) C_ts Ad^T
/// Both factors are taken as independent unless their cross covariance is given.
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam {

struct PoseWithCovariance {
  Pose pose;
  Mat6 covariance = Mat6::Zero();  ///< of the left increment [rotation, translation]; rad^2, rad m, m^2
};

/// c_from_a = c_from_b * b_from_a. `cross` is E[xi_cb xi_ba^T], zero when the two are independent.
PROCAM_EXPORT PoseWithCovariance compose(const PoseWithCovariance& c_from_b,
                                         const PoseWithCovariance& b_from_a,
                                         const Mat6& cross = Mat6::Zero());

PROCAM_EXPORT PoseWithCovariance inverse(const PoseWithCovariance& target_from_source);

/// b_from_a = (c_from_b)^-1 * c_from_a: two things seen from one place. `cross` is E[xi_cb xi_ca^T]: what
/// both share (the common camera's own error) cancels only when it is given.
PROCAM_EXPORT PoseWithCovariance relative(const PoseWithCovariance& c_from_b,
                                          const PoseWithCovariance& c_from_a,
                                          const Mat6& cross = Mat6::Zero());

/// Covariance of target_from_source * point, for an exact point: J = [-hat(p), I] in the target frame.
PROCAM_EXPORT Mat3 point_covariance(const PoseWithCovariance& target_from_source,
                                    const Vec3& point_in_source);

/// A covariance matrix whose rows have names, e.g. "projector.fx", "rig_from_projector.rx": what a solver
/// leaves behind.
struct NamedCovariance {
  std::vector<std::string> names;
  MatX matrix;  ///< names.size() square, units of the named parameters

  bool empty() const { return names.empty(); }
  PROCAM_EXPORT std::optional<Eigen::Index> index_of(const std::string& name) const;
  /// One standard deviation; 0 for a parameter that was held fixed (not in the list).
  PROCAM_EXPORT double sigma(const std::string& name) const;
  /// The rows and columns of these names, in this order; zero where a name was held fixed.
  PROCAM_EXPORT MatX block(const std::vector<std::string>& wanted) const;
};

/// Names of a pose's six increments below a prefix: prefix.rx ry rz tx ty tz.
PROCAM_EXPORT std::vector<std::string> pose_increment_names(const std::string& prefix);

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/geometry/detail/covariance_body.hpp"
#endif
