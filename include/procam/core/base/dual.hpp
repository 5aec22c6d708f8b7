#pragma once
/// Forward-mode automatic differentiation in N variables: value `a` and gradient `v`, the layout of Ceres'
/// Jet, so that one templated formula serves double, Dual (inside core, which knows no Ceres) and Jet.
///
///   Dual<2> x(3.0, 0), y(4.0, 1);          // two variables
///   Dual<2> r = sqrt(x * x + y * y);       // r.a == 5, r.v == (0.6, 0.8)
#include <Eigen/Core>
#include <cmath>

namespace procam {

template <int N>
struct Dual {
  using Gradient = Eigen::Matrix<double, N, 1>;
  double a = 0;
  Gradient v = Gradient::Zero();

  Dual() = default;
  Dual(double value) : a(value) {}  // NOLINT: constants enter formulas without ceremony, as with Jet
  /// Variable number `index`.
  Dual(double value, int index) : a(value) { v[index] = 1; }
  Dual(double value, const Gradient& gradient) : a(value), v(gradient) {}

  Dual& operator+=(const Dual& o) { return *this = *this + o; }
  Dual& operator-=(const Dual& o) { return *this = *this - o; }
  Dual& operator*=(const Dual& o) { return *this = *this * o; }
  Dual& operator/=(const Dual& o) { return *this = *this / o; }

  friend Dual operator+(const Dual& x, const Dual& y) { return {x.a + y.a, x.v + y.v}; }
  friend Dual operator-(const Dual& x, const Dual& y) { return {x.a - y.a, x.v - y.v}; }
  friend Dual operator-(const Dual& x) { return {-x.a, -x.v}; }
  friend Dual operator*(const Dual& x, const Dual& y) { return {x.a * y.a, x.a * y.v + y.a * x.v}; }
  friend Dual operator/(const Dual& x, const Dual& y) {
    const double inverse = 1 / y.a, q = x.a * inverse;
    return {q, (x.v - q * y.v) * inverse};
  }
  friend bool operator<(const Dual& x, const Dual& y) { return x.a < y.a; }
  friend bool operator>(const Dual& x, const Dual& y) { return x.a > y.a; }
  friend bool operator<=(const Dual& x, const Dual& y) { return x.a <= y.a; }
  friend bool operator>=(const Dual& x, const Dual& y) { return x.a >= y.a; }
  friend bool operator==(const Dual& x, const Dual& y) { return x.a == y.a; }
  friend bool operator!=(const Dual& x, const Dual& y) { return x.a != y.a; }

  friend Dual sqrt(const Dual& x) {
    const double root = std::sqrt(x.a);
    return {root, x.v / (2 * root)};
  }
  friend Dual sin(const Dual& x) { return {std::sin(x.a), std::cos(x.a) * x.v}; }
  friend Dual cos(const Dual& x) { return {std::cos(x.a), -std::sin(x.a) * x.v}; }
  friend Dual atan2(const Dual& y, const Dual& x) {
    return {std::atan2(y.a, x.a), (x.a * y.v - y.a * x.v) / (x.a * x.a + y.a * y.a)};
  }
  friend Dual abs(const Dual& x) { return x.a < 0 ? -x : x; }
};

}  // namespace procam

namespace Eigen {
/// Lets Eigen matrices hold Dual numbers.
template <int N>
struct NumTraits<procam::Dual<N>> : GenericNumTraits<double> {
  using Real = procam::Dual<N>;
  using NonInteger = procam::Dual<N>;
  using Nested = procam::Dual<N>;
  using Literal = double;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 1,
    ReadCost = 1,
    AddCost = N + 1,
    MulCost = 3 * N + 1
  };
};
template <int N, typename BinaryOp>
struct ScalarBinaryOpTraits<procam::Dual<N>, double, BinaryOp> {
  using ReturnType = procam::Dual<N>;
};
template <int N, typename BinaryOp>
struct ScalarBinaryOpTraits<double, procam::Dual<N>, BinaryOp> {
  using ReturnType = procam::Dual<N>;
};
}  // namespace Eigen
