#include "procam/track/detail/message_check.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "procam/core/base/detail/plain_text.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/track/wire.hpp"

namespace procam::track::internal {
namespace {

template <typename Derived>
bool within(const Eigen::MatrixBase<Derived>& m, double most) {
  return m.allFinite() && m.cwiseAbs().maxCoeff() <= most;
}

}  // namespace

const char* why_malformed(const StampedPose& message) {
  if (!procam::internal::is_plain_text(message.frame) || !procam::internal::is_plain_text(message.child))
    return "a frame's name is not UTF-8, or has control characters";
  // 1e12 s are 30000 years; beyond, a double does not tell milliseconds.
  if (message.stamp && !(std::abs(*message.stamp) <= 1e12)) return "the stamp is not a time in seconds";
  const Eigen::Quaterniond& q = message.frame_from_child.rotation;
  if (!q.coeffs().allFinite() || std::abs(q.norm() - 1) > 0.01) return "the quaternion's length is not 1";
  if (!within(message.frame_from_child.translation, kFarthest))
    return "the position is not finite, or beyond 1000 km";
  if (message.twist && !within(*message.twist, kFarthest)) return "the twist is not finite or too large";
  if (message.angular_rate && !within(*message.angular_rate, kFarthest))
    return "the angular rate is not finite or too large";
  if (message.frame.size() > limits::kFrameNameBytes || message.child.size() > limits::kFrameNameBytes)
    return "a frame's name is longer than 255 bytes";
  if (message.covariance) {
    const Mat6& c = *message.covariance;
    if (!within(c, kFarthest * kFarthest)) return "the covariance is not finite or too large";
    const double size = c.cwiseAbs().maxCoeff();
    if ((c - c.transpose()).cwiseAbs().maxCoeff() > 1e-6 * size) return "the covariance is not symmetric";
    if (size > 0) {
      // Semidefinite up to what single precision and printed digits lose.
      Mat6 lifted = c;
      lifted.diagonal().array() += 1e-6 * size;
      if (Eigen::LLT<Mat6>(lifted).info() != Eigen::Success) return "the covariance has a negative variance";
    }
  }
  return nullptr;
}

void make_unit(Eigen::Quaterniond& rotation) {
  if (std::abs(rotation.norm() - 1) > 1e-14) rotation.normalize();
}

}  // namespace procam::track::internal
