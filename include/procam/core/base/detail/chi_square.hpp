#pragma once
/// The chi-square distribution's upper tail, for small whole degrees of freedom.
#include <algorithm>
#include <cmath>

namespace procam::internal {

/// P(X > x), by the recurrence Q_{k+2} = Q_k + (x/2)^{k/2} exp(-x/2) / Gamma(k/2 + 1) from Q_1 =
/// erfc(sqrt(x/2)) and Q_2 = exp(-x/2) (Abramowitz & Stegun 26.4.8).
inline double chi_square_tail(double x, int degrees_of_freedom) {
  if (!(x > 0)) return 1;
  const double half = 0.5 * x;
  int k = degrees_of_freedom % 2 == 1 ? 1 : 2;
  double tail = k == 1 ? std::erfc(std::sqrt(half)) : std::exp(-half);
  // log Gamma(k/2 + 1) as a sum: std::lgamma() writes a variable of the whole process (signgam), which threads share.
  double log_gamma = k == 1 ? -0.12078223763524522 : 0;  // log(sqrt(pi) / 2)
  for (; k < degrees_of_freedom; k += 2) {
    tail += std::exp(0.5 * k * std::log(half) - half - log_gamma);
    log_gamma += std::log(0.5 * k + 1);
  }
  return std::min(1.0, tail);
}

/// The x with chi_square_tail(x) = rate, 0 < rate < 1.
inline double chi_square_limit(double rate, int degrees_of_freedom) {
  double low = 0, high = 1;
  while (chi_square_tail(high, degrees_of_freedom) > rate) high *= 2;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (chi_square_tail(middle, degrees_of_freedom) > rate ? low : high) = middle;
  }
  return high;
}

}  // namespace procam::internal
