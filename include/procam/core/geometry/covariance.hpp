#pragma once
/// Uncertainty that travels: poses with a 6x6 covariance, and covariances whose rows have names.
///
/// The increment is on the left, order [rotation, translation]: target_from_source = se3_exp(xi) * mean, xi ~
/// N(0, C). To first order (Barfoot, "State Estimation for Robotics", 2017, section 7.3):
///   c_from_a = c_from_b b_from_a:  C_ca = C_cb + Ad(c_from_b) C_ba Ad^T
///   source_from_target = inverse:  C_st = Ad(source_from_target) C_ts Ad^T
/// Both factors are taken as independent unless their cross covariance is given.
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam {

struct PoseWithCovariance {
  Pose pose;
  Mat6 covariance = Mat6::Zero();  ///< of the left increment [rotation, translation]; rad^2, rad m, m^2
};

/// c_from_a = c_from_b * b_from_a. `cross` is E[xi_cb xi_ba^T], zero when the two are independent.
inline PoseWithCovariance compose(const PoseWithCovariance& c_from_b, const PoseWithCovariance& b_from_a,
                                  const Mat6& cross = Mat6::Zero()) {
  const Mat6 ad = adjoint(c_from_b.pose);
  const Mat6 mixed = cross * ad.transpose();
  return {c_from_b.pose * b_from_a.pose,
          c_from_b.covariance + ad * b_from_a.covariance * ad.transpose() + mixed + mixed.transpose()};
}

inline PoseWithCovariance inverse(const PoseWithCovariance& target_from_source) {
  const Pose source_from_target = target_from_source.pose.inverse();
  const Mat6 ad = adjoint(source_from_target);
  return {source_from_target, ad * target_from_source.covariance * ad.transpose()};
}

/// b_from_a = (c_from_b)^-1 * c_from_a: two things seen from one place. `cross` is E[xi_cb xi_ca^T]: what
/// both share (the common camera's own error) cancels only when it is given.
inline PoseWithCovariance relative(const PoseWithCovariance& c_from_b, const PoseWithCovariance& c_from_a,
                                   const Mat6& cross = Mat6::Zero()) {
  const Pose b_from_c = c_from_b.pose.inverse();
  const Mat6 ad = adjoint(b_from_c);  // xi_ba = Ad (xi_ca - xi_cb)
  return {b_from_c * c_from_a.pose,
          ad * (c_from_a.covariance + c_from_b.covariance - cross - cross.transpose()) * ad.transpose()};
}

/// Covariance of target_from_source * point, for an exact point: J = [-hat(p), I] in the target frame.
inline Mat3 point_covariance(const PoseWithCovariance& target_from_source, const Vec3& point_in_source) {
  Eigen::Matrix<double, 3, 6> j;
  j << -hat(Vec3(target_from_source.pose * point_in_source)), Mat3::Identity();
  return j * target_from_source.covariance * j.transpose();
}

/// A covariance matrix whose rows have names, e.g. "projector.fx", "rig_from_projector.rx": what a solver
/// leaves behind.
struct NamedCovariance {
  std::vector<std::string> names;
  MatX matrix;  ///< names.size() square, units of the named parameters

  bool empty() const { return names.empty(); }
  std::optional<Eigen::Index> index_of(const std::string& name) const {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) return std::nullopt;
    return Eigen::Index(found - names.begin());
  }
  /// One standard deviation; 0 for a parameter that was held fixed (not in the list).
  double sigma(const std::string& name) const {
    const auto i = index_of(name);
    // This order of max() lets NaN through: an unknown variance must not read as "held fixed".
    return i ? std::sqrt(std::max(matrix(*i, *i), 0.0)) : 0.0;
  }
  /// The rows and columns of these names, in this order; zero where a name was held fixed.
  MatX block(const std::vector<std::string>& wanted) const {
    std::vector<std::optional<Eigen::Index>> index;
    for (const std::string& name : wanted) index.push_back(index_of(name));
    MatX out = MatX::Zero(Eigen::Index(wanted.size()), Eigen::Index(wanted.size()));
    for (std::size_t r = 0; r < wanted.size(); ++r)
      for (std::size_t c = 0; c < wanted.size(); ++c)
        if (index[r] && index[c]) out(Eigen::Index(r), Eigen::Index(c)) = matrix(*index[r], *index[c]);
    return out;
  }
};

/// Names of a pose's six increments below a prefix: prefix.rx ry rz tx ty tz.
inline std::vector<std::string> pose_increment_names(const std::string& prefix) {
  return {prefix + ".rx", prefix + ".ry", prefix + ".rz", prefix + ".tx", prefix + ".ty", prefix + ".tz"};
}

}  // namespace procam
