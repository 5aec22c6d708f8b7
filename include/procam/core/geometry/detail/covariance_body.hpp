#pragma once
/// The bodies of covariance.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include <algorithm>
#include <cmath>

#include "procam/core/geometry/covariance.hpp"

namespace procam {

PROCAM_CORE_INLINE PoseWithCovariance compose(const PoseWithCovariance& c_from_b,
                                              const PoseWithCovariance& b_from_a, const Mat6& cross) {
  const Mat6 ad = adjoint(c_from_b.pose);
  const Mat6 mixed = cross * ad.transpose();
  return {c_from_b.pose * b_from_a.pose,
          c_from_b.covariance + ad * b_from_a.covariance * ad.transpose() + mixed + mixed.transpose()};
}

PROCAM_CORE_INLINE PoseWithCovariance inverse(const PoseWithCovariance& target_from_source) {
  const Pose source_from_target = target_from_source.pose.inverse();
  const Mat6 ad = adjoint(source_from_target);
  return {source_from_target, ad * target_from_source.covariance * ad.transpose()};
}

PROCAM_CORE_INLINE PoseWithCovariance relative(const PoseWithCovariance& c_from_b,
                                               const PoseWithCovariance& c_from_a, const Mat6& cross) {
  const Pose b_from_c = c_from_b.pose.inverse();
  const Mat6 ad = adjoint(b_from_c);  // xi_ba = Ad (xi_ca - xi_cb)
  return {b_from_c * c_from_a.pose,
          ad * (c_from_a.covariance + c_from_b.covariance - cross - cross.transpose()) * ad.transpose()};
}

PROCAM_CORE_INLINE Mat3 point_covariance(const PoseWithCovariance& target_from_source,
                                         const Vec3& point_in_source) {
  Eigen::Matrix<double, 3, 6> j;
  j << -hat(Vec3(target_from_source.pose * point_in_source)), Mat3::Identity();
  return j * target_from_source.covariance * j.transpose();
}

PROCAM_CORE_INLINE std::optional<Eigen::Index> NamedCovariance::index_of(const std::string& name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return Eigen::Index(found - names.begin());
}

PROCAM_CORE_INLINE double NamedCovariance::sigma(const std::string& name) const {
  const auto i = index_of(name);
  // This order of max() lets NaN through: an unknown variance must not read as "held fixed".
  return i ? std::sqrt(std::max(matrix(*i, *i), 0.0)) : 0.0;
}

PROCAM_CORE_INLINE MatX NamedCovariance::block(const std::vector<std::string>& wanted) const {
  std::vector<std::optional<Eigen::Index>> index;
  for (const std::string& name : wanted) index.push_back(index_of(name));
  MatX out = MatX::Zero(Eigen::Index(wanted.size()), Eigen::Index(wanted.size()));
  for (std::size_t r = 0; r < wanted.size(); ++r)
    for (std::size_t c = 0; c < wanted.size(); ++c)
      if (index[r] && index[c]) out(Eigen::Index(r), Eigen::Index(c)) = matrix(*index[r], *index[c]);
  return out;
}

PROCAM_CORE_INLINE std::vector<std::string> pose_increment_names(const std::string& prefix) {
  return {prefix + ".rx", prefix + ".ry", prefix + ".rz", prefix + ".tx", prefix + ".ty", prefix + ".tz"};
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
