#pragma once
/// The last step of corner detection: fit the crossing of two blurred edges. Equation in
/// detect/chessboard.hpp.
#include <optional>

#include "procam/core/base/image.hpp"
#include "procam/core/base/types.hpp"

namespace procam::detect {

/// The print round a corner by its neighbours: the board's point (a, b) squares away appears at
/// corner + e_x a + e_y b + (e_xx a^2 + e_yy b^2) / 2.
struct CornerNeighbourhood {
  Vec2 corner;                                    ///< first estimate, pixels
  Vec2 e_x, e_y;                                  ///< one square along the row and the column
  Vec2 e_xx = Vec2::Zero(), e_yy = Vec2::Zero();  ///< second derivatives: lens and perspective bend the edges
  double sigma_xx = 0, sigma_yy = 0;              ///< standard deviations of these across the edges, pixels
  double min_contrast = 0;  ///< light minus dark by their mean: with less at `corner`, there is no crossing
  double clear = 1;         ///< pixels farther than this from both edges, in squares, show something else
};

struct CornerFit {
  Vec2 corner;
  Mat2 covariance;      ///< pixel^2
  double contrast = 0;  ///< 2 b: light minus dark; positive where the square at (+x, +y) is light
  double mean = 0;      ///< a: between light and dark
  double blur = 0;      ///< s, pixels
  double residual = 0;  ///< RMS of the fit, grey levels
  Eigen::Matrix<double, 14, 1> parameters;  ///< of the model, for a further fit to start from
};

/// Of a large window: a lattice of its pixels, a few hundredths of a pixel off; or every pixel near its edges and a
/// lattice of the flat ones, as precise as all of them.
enum class FitEffort { kQuick, kFull };

/// nullopt where the window leaves the image or there is no such crossing.
std::optional<CornerFit> fit_corner(const ViewU8& image, const CornerNeighbourhood& around,
                                    double window_share, FitEffort effort = FitEffort::kFull);

/// A full fit that starts from an earlier one, of the edges' bends too: those of the neighbourhood are known to their standard
/// deviations.
std::optional<CornerFit> fit_corner_and_bends(const ViewU8& image, const CornerNeighbourhood& around,
                                              double window_share, const CornerFit& before);

/// The same with one more term of the light: the halo that a camera's sharpening leaves beside
/// edges, c (h(d) - e(d)), where e is the product of the two edges' erf and h the same with a larger blur.
/// c < 0: overshoot; c > 0: a wide skirt. Without an earlier fit it starts from the neighbourhood.
std::optional<CornerFit> fit_corner_with_halo(const ViewU8& image, const CornerNeighbourhood& around,
                                              double window_share, const CornerFit* before);

}  // namespace procam::detect
