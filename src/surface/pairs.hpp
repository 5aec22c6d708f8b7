#pragma once
/// One surface's pairs -> its homography, its residuals, and the pair that does not fit.
#include "procam/core/surface/surface.hpp"
#include "procam/surface/solve.hpp"

namespace procam::surface {

struct SolvedPairs {
  Mat3 destination_from_content;  ///< positive denominators in front
  double rms = 0;                 ///< destination units
  std::vector<double> residuals;
};

/// The deviation of a pair from the others that is reported.
struct OutlierLimit {
  double unit = 1;  ///< destination units in one mm or px
  const char* unit_name = "px";
  double min_deviation = 0;     ///< of those units
  double false_alarm_rate = 0;  ///< of one surface whose pairs have Gaussian errors
};

/// Throws Error naming the surface.
SolvedPairs solve_pairs(const Surface& surface, const Points2& content, const Points2& destination);

/// Warns of a pair without which the others fit better than chance allows. With SSE the weighted sum of
/// squared residuals of all N pairs, SSE_k without pair k, and d = 2 (N - 1) - 8 degrees of freedom left: for
/// Gaussian errors (SSE - SSE_k) / 2 over SSE_k / d is F-distributed with (2, d) degrees of freedom, whose
/// tail is (SSE_k / SSE)^(d/2). Needs N >= 6. Where the others fit alike without one or another, all of these are named.
void warn_of_outlying_pair(const Surface& surface, const Points2& content, const Points2& destination,
                           const OutlierLimit& limit, Diagnostics& diagnostics);

}  // namespace procam::surface
