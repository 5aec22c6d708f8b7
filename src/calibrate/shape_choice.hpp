#pragma once
/// Private to calibrate: which shape of the board the views show.
#include <vector>

#include "procam/calibrate/result.hpp"
#include "solve.hpp"
#include "start.hpp"

namespace procam::calibrate {

/// The board as printed, or as the views see it.
struct ShapedSolution {
  Correspondences data;  ///< the order of symmetric boards settled
  Solution solution;
  EstimatedShape shape;
  std::vector<int> turned;  ///< views whose order the shape settled
  /// Numbers that the shape has, without the place and the scale that poses share with it.
  double freedom = 0;
};

/// As printed and flat, bent like a sheet (3 numbers), or with a place of its own for each point (3 numbers a point): what
/// `options` ask for, or the simplest that predicts held-out views well.
ShapedSolution solve_with_shape(const Correspondences& data, const Start& start, const Options& options);

}  // namespace procam::calibrate
