#pragma once
#include <algorithm>
#include <array>

#include "procam/core/base/types.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::track::internal {

/// How much messages scatter from one to the next, from third differences: a motion whose acceleration does
/// not change has none. With x_i at t_i and c_i = 1 / prod_{j != i} (t_i - t_j), sum c_i x_i is free of every
/// quadratic, and of variance sigma^2 sum c_i^2 for independent noise.
class Scatter {
 public:
  Scatter() { ratio_.setOnes(); }
  bool known() const { return count_ >= kScatterFrom; }
  /// Measured variance over the stated one, of each component.
  const Vec6& ratio() const { return ratio_; }
  void forget_row() { row_ = 0; }

  void add(double time, const Pose& pose, const Vec6& stated_variance) {
    for (std::size_t i = 0; i < 3; ++i) last_[i] = last_[i + 1];
    last_[3] = {time, pose};
    if (++row_ < 4 || last_[3].time - last_[0].time > 0.7) return;
    std::array<double, 4> c = {};
    double norm2 = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      double product = 1;
      for (std::size_t j = 0; j < 4; ++j)
        if (j != i) product *= last_[i].time - last_[j].time;
      if (product == 0) return;
      c[i] = 1 / product;
      norm2 += c[i] * c[i];
    }
    Vec6 difference = Vec6::Zero();
    const Pose first = last_[1].pose.inverse();
    for (std::size_t i = 0; i < 4; ++i)
      if (i != 1) difference += c[i] * se3_log(first * last_[i].pose);
    const Vec6 now = difference.cwiseAbs2() / norm2;
    ++count_;
    const double share = 1.0 / std::min(count_, kScatterOver);
    for (Eigen::Index k = 0; k < 6; ++k) {
      // One message that is far off does not make all the others doubtful.
      const double seen = now[k] / stated_variance[k];
      ratio_[k] += share * ((known() ? std::min(seen, 9 * ratio_[k]) : seen) - ratio_[k]);
    }
  }

 private:
  /// Third differences until the scatter is believed, and over how many it is averaged.
  static constexpr int kScatterFrom = 20, kScatterOver = 100;

  struct At {
    double time = 0;
    Pose pose;
  };
  std::array<At, 4> last_;
  int row_ = 0, count_ = 0;
  Vec6 ratio_;
};

}  // namespace procam::track::internal
