#pragma once
/// The factors of a small symmetric positive definite matrix, A = L D L^T (Golub & Van Loan, "Matrix
/// Computations", 4.1.2), in plain loops. Eigen's LDLT gives the same numbers; compiling it for one fixed
/// size costs every file that includes it some four seconds.
#include <Eigen/Core>

#include "procam/core/base/types.hpp"

namespace procam {

/// Without pivoting: for normal equations, whose diagonal is never negative. A direction that A does not
/// determine about (a pivot of zero) gets the answer zero, as with Eigen's LDLT; what is not positive
/// definite shows in pivots().
template <int N>
class Cholesky {
 public:
  using Matrix = Eigen::Matrix<double, N, N>;
  using Vector = Eigen::Matrix<double, N, 1>;

  explicit Cholesky(const Matrix& a) : lower_(a) {
    for (int j = 0; j < N; ++j) {
      double pivot = a(j, j);
      for (int k = 0; k < j; ++k) pivot -= lower_(j, k) * lower_(j, k) * pivots_[k];
      pivots_[j] = pivot;
      inverse_pivots_[j] = std::abs(pivot) > kNothing ? 1 / pivot : 0;
      for (int i = j + 1; i < N; ++i) {
        double entry = a(i, j);
        for (int k = 0; k < j; ++k) entry -= lower_(i, k) * lower_(j, k) * pivots_[k];
        lower_(i, j) = entry * inverse_pivots_[j];
      }
    }
  }

  /// A^-1 right, for right-hand sides of N rows.
  template <typename Right>
  Eigen::Matrix<double, N, Right::ColsAtCompileTime> solve(const Right& right) const {
    static_assert(Right::RowsAtCompileTime == N, "as many rows as the matrix has");
    Eigen::Matrix<double, N, Right::ColsAtCompileTime> x = right;
    for (int column = 0; column < int(x.cols()); ++column) {
      for (int i = 1; i < N; ++i)
        for (int k = 0; k < i; ++k) x(i, column) -= lower_(i, k) * x(k, column);
      for (int i = 0; i < N; ++i) x(i, column) *= inverse_pivots_[i];
      for (int i = N - 2; i >= 0; --i)
        for (int k = i + 1; k < N; ++k) x(i, column) -= lower_(k, i) * x(k, column);
    }
    return x;
  }

  Matrix inverse() const { return solve(Matrix(Matrix::Identity())); }

  /// D: all positive when A is positive definite.
  const Vector& pivots() const { return pivots_; }

 private:
  static constexpr double kNothing = 1e-300;

  Matrix lower_;
  Vector pivots_, inverse_pivots_;
};

}  // namespace procam
