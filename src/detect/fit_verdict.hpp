#pragma once
/// Private to detect: when a fit of a board's feature is not to be believed, and how rejected ones are reported.
#include <string>

#include "procam/core/base/error.hpp"

namespace procam::detect {

/// A fit this many times worse than the median fit of its image has something else in its window (a border of
/// light, a shadow, a cover's edge), which pulls it away. On real boards without one, none is.
inline constexpr double kWorstResidual = 2;

/// Rejected features of a board. A few are usual, where the border of the projected frame crosses the print: a
/// note. Above this share they are a warning.
inline constexpr double kUsualRejectedShare = 0.25;

/// `what` in the plural, `where`: what else than the border of the light, blur and glare may be the cause.
inline void report_rejected(Diagnostics& diagnostics, const std::string& code, int rejected, int all,
                            const std::string& what, const std::string& where) {
  if (rejected <= 0) return;
  const std::string message = std::to_string(rejected) + " of " + std::to_string(all) + " " + what +
                              " could not be refined and are rejected: the border of the projected light, "
                              "blur, glare, " +
                              where;
  if (rejected > kUsualRejectedShare * all)
    diagnostics.warn(code, message);
  else
    diagnostics.note(code, message);
}

}  // namespace procam::detect
