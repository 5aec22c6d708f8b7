#pragma once
/// Small holes in a depth image, bridged where the surface goes on behind them.
#include "procam/core/base/image.hpp"

namespace procam::scan {

/// Depths of pixels that were not measured, with measured ones on both sides along x or y, at most `max_hole` pixels between them.
/// The inverse depth, which is linear on planes, is interpolated where both sides belong to one surface: each side's slope,
/// continued over the hole, meets the other side within three standard deviations plus `max_deviation` (metres) plus a tenth of
/// the depth between them. So steps in depth stay open. `depth` and `sigma` in metres, 0 where not measured; filled pixels have
/// the larger standard deviation of the two sides.
void bridge_holes(ImageF& depth, ImageF& sigma, int max_hole, double max_deviation);

}  // namespace procam::scan
