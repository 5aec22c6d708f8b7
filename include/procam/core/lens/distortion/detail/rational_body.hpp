#pragma once
/// The body of rational.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include "procam/core/lens/distortion/detail/inverse.hpp"
#include "procam/core/lens/distortion/rational.hpp"

namespace procam {

PROCAM_CORE_INLINE std::optional<Vec3> RationalDistortion::undistort(const double* c, const Vec2& distorted) {
  return internal::undistort_by_newton<RationalDistortion>(c, distorted);
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
