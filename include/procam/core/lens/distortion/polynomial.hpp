#pragma once
/// Is a polynomial positive on an interval? The question behind every fold of a lens model: a radial
/// distortion may be inverted up to the first root of its derivative and no further.
#include <array>

namespace procam {
namespace internal {

/// All Bernstein coefficients positive is sufficient; an end value <= 0 refutes; otherwise de Casteljau
/// halves.
template <int Degree>
bool bernstein_positive(const std::array<double, Degree + 1>& b, int depth) {
  if (!(b.front() > 0) || !(b.back() > 0)) return false;
  bool all = true;
  for (double c : b) all = all && c > 0;
  if (all) return true;
  // Still undecided on 2^-20 of the interval: it touches zero there, a fold for every practical purpose.
  if (depth == 0) return false;
  std::array<double, Degree + 1> left, right = b;
  for (int i = 0; i <= Degree; ++i) {
    left[i] = right[0];
    for (int j = 0; j < Degree - i; ++j) right[j] = 0.5 * (right[j] + right[j + 1]);
  }
  return bernstein_positive<Degree>(left, depth - 1) && bernstein_positive<Degree>(right, depth - 1);
}

template <int Degree>
bool polynomial_positive_by_bernstein(const std::array<double, Degree + 1>& a, double end) {
  // b_j = sum_{i<=j} C(j,i)/C(n,i) a_i end^i
  std::array<double, Degree + 1> scaled;  // a_i end^i / C(n,i)
  double power = 1, binomial = 1;
  for (int i = 0; i <= Degree; ++i) {
    scaled[i] = a[i] * power / binomial;
    power *= end;
    binomial = binomial * (Degree - i) / (i + 1);
  }
  std::array<double, Degree + 1> b;
  for (int j = 0; j <= Degree; ++j) {
    double sum = 0, choose = 1;
    for (int i = 0; i <= j; ++i) {
      sum += choose * scaled[i];
      choose = choose * (j - i) / (i + 1);
    }
    b[j] = sum;
  }
  return bernstein_positive<Degree>(b, 20);
}

}  // namespace internal

/// A number that a[0] + a[1] s + ... + a[Degree] s^Degree does not fall below for any s in [0, end], end >=
/// 0: a[0] and the negative terms at `end`. NaN for NaN.
template <int Degree>
double polynomial_lower_bound(const std::array<double, Degree + 1>& a, double end) {
  double lowest = 0;
  for (int i = Degree; i >= 1; --i) lowest = (lowest + (a[i] > 0 ? 0 : a[i])) * end;
  return lowest + a[0];
}

/// Is a[0] + a[1] s + ... + a[Degree] s^Degree > 0 for all s in [0, end], end >= 0? False for NaN.
///
/// The lower bound settles nearly every point of a real picture in one Horner sum; Bernstein's form decides
/// the others.
/// Source: Farouki, "The Bernstein polynomial basis: a centennial retrospective", 2012, section 5.
template <int Degree>
bool polynomial_positive(const std::array<double, Degree + 1>& a, double end) {
  return polynomial_lower_bound<Degree>(a, end) > 0 ||
         internal::polynomial_positive_by_bernstein<Degree>(a, end);
}

}  // namespace procam
