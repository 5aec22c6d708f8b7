#pragma once
/// Private to detect: when a fit of a board's feature is not to be believed.

namespace procam::detect {

/// A fit this many times worse than the median fit of its image has something else in its window (a border of
/// light, a shadow, a cover's edge), which pulls it away. On real boards without one, none is.
inline constexpr double kWorstResidual = 2;

}  // namespace procam::detect
