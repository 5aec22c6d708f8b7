#pragma once
/// How a print appears round a corner of a grid: position, directions and bending, from the corners beside it.
#include <optional>
#include <vector>

#include "corner_fit.hpp"
#include "corner_grid.hpp"

namespace procam::detect {

/// Second derivatives are differences of three corners in a line, about the corner or, at the grid's rim and beside
/// corners that were not fitted, about the next one. Their standard deviations are those of the corners, and
/// there also the change of the difference from one corner to the next. `fits`: of the grid's corners, or
/// empty; a corner without a fit is known to half a pixel.
CornerNeighbourhood neighbourhood_in_grid(const CornerGrid& grid,
                                          const std::vector<std::optional<CornerFit>>& fits, int column,
                                          int row);

}  // namespace procam::detect
