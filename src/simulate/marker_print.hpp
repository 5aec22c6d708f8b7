#pragma once
/// A marker as a picture of one texel a cell.
#include "procam/core/base/image.hpp"
#include "procam/core/board/marker.hpp"

namespace procam::simulate::internal {

/// 255 white, 0 black: the cells, their black border, and `rim_cells` of white round it.
inline ImageU8 marker_print(int id, const MarkerCells& codes, int rim_cells) {
  const int border = rim_cells + 1, cells = codes.per_side + 2 * border;
  ImageU8 print(cells, cells);
  for (int r = 0; r < cells; ++r)
    for (int c = 0; c < cells; ++c) print.at(c, r) = codes.is_white(id, r - border, c - border) ? 255 : 0;
  return print;
}

}  // namespace procam::simulate::internal
