#pragma once
/// Points of a room that lie on boards share their board's error: of its pose and of its scale.
///
/// Model, for the residuals of one board's points, in pixels, at the solution and to first order:
///
///   r = J x + B d + e,   d ~ N(0, s^2 I_7),   e ~ N(0, f^2 I)
///
/// B d moves the board as a whole: translation, rotation and scale about its centre, each in metres of rms
/// displacement of its points. s and f are those of largest restricted likelihood (REML; Patterson and
/// Thompson, "Recovery of inter-block information when block sizes are unequal", Biometrika 58, 1971), which
/// does not take the unknowns x for known. x is then least squares with the boards' errors allowed for.
#include <optional>
#include <vector>

#include "procam/core/rig/observation.hpp"

namespace procam::calibrate {

/// Which board every pair lies on, from 0; -1 for none. A board is a run of at least six points in file order
/// that lie in one plane, within half a percent of their extent. Empty with fewer than three boards: then
/// their errors are not separable from those of the lens and its pose.
std::vector<int> boards_of(const std::vector<PointPair>& pairs);

/// One linearised problem. Rows of the pairs first, two each, all in the same unit; then rows of priors,
/// whitened.
struct SharedErrorEquations {
  MatX by_unknowns;
  VecX residuals;
  MatX by_point;             ///< rows of the pairs x 3: derivative by the point in the world
  std::vector<Vec3> points;  ///< of each pair
  std::vector<int> boards;   ///< of each pair, as boards_of() counts
};

struct SharedError {
  double board_sigma = 0;      ///< s, metres
  double pixel_sigma = 0;      ///< f, in the unit of the residuals
  double likelihood_gain = 0;  ///< 2 ln of the likelihood ratio against s = 0; chi-squared with one degree
  VecX step;                   ///< of the unknowns towards the solution
  MatX covariance;             ///< of the unknowns
  /// Residuals of each pair, predicted without its board (without itself where it lies on none); unset where
  /// the others do not determine the unknowns.
  std::vector<std::optional<Vec2>> loo_residuals;
};

/// nullopt when the normal equations cannot be solved.
std::optional<SharedError> estimate_shared_error(const SharedErrorEquations& equations);

}  // namespace procam::calibrate
