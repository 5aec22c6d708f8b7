#pragma once
/// A smooth scalar field over the board, fitted robustly to scattered values.
///
///   f(s, t) = sum_k c_k B_k(s, t),   c = argmin sum_i w_i (f(s_i, t_i) - y_i)^2 + lambda |D2 c|^2
///
/// with uniform cubic tensor-product B-splines B_k and D2 their second differences along s, t and both
/// (P-splines: Eilers & Marx, Statistical Science 11(2), 1996). lambda is the one that predicts left-out
/// stripes best.
#include <array>
#include <vector>

#include "procam/core/base/types.hpp"

namespace procam::pattern {

/// One value with its expected standard deviation. Samples of one `group` err together.
struct FieldSample {
  Vec2 at;  ///< (s, t), squares
  double value = 0;
  double sigma = 1;
  int stripe = 0;  ///< number of the boundary; held out together when lambda is chosen
  int group = 0;   ///< 0 .. group_count-1
};

class SmoothField {
 public:
  /// Over [low, high], with knots at most `spacing` apart.
  SmoothField(const Vec2& low, const Vec2& high, double spacing);

  int size() const { return count_[0] * count_[1]; }
  /// Splines farther apart in their numbers do not overlap.
  int band_width() const { return 3 * count_[0] + 4; }
  void fit(const std::vector<FieldSample>& samples, int group_count);

  double value(const Vec2& at) const;
  Vec2 gradient(const Vec2& at) const;
  /// Variance of value(at): from the scatter of whole groups (cluster-robust "sandwich" covariance: Liang &
  /// Zeger, Biometrika 73(1), 1986), plus what stripes of the finest bit and the others systematically
  /// disagree by.
  double variance(const Vec2& at) const;

 private:
  struct Support {
    int first[2];
    double fraction[2];  ///< of a knot interval
  };
  Support support(const Vec2& at) const;
  class Fitting;
  double value(const Support& s) const;
  VecX basis(const Vec2& at) const;
  MatX bending() const;

  Vec2 low_, step_;
  std::array<int, 2> count_;
  VecX coefficients_;
  MatX covariance_;
  double lambda_ = 0;  ///< relative to the mean diagonal of the normal equations
  double systematic_variance_ = 0;
};

}  // namespace procam::pattern
