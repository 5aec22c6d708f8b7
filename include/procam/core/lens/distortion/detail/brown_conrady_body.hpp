#pragma once
/// The body of brown_conrady.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include "procam/core/lens/distortion/brown_conrady.hpp"
#include "procam/core/lens/distortion/detail/inverse.hpp"

namespace procam {

PROCAM_CORE_INLINE std::optional<Vec3> BrownConrady::undistort(const double* c, const Vec2& distorted) {
  return internal::undistort_by_newton<BrownConrady>(c, distorted);
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
