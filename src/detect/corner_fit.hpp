#pragma once
/// The last step of corner detection: fit the crossing of two blurred edges. Equation in
/// detect/chessboard.hpp.
#include <optional>

#include "procam/core/base/image.hpp"
#include "procam/core/base/types.hpp"

namespace procam::detect {

/// What the neighbouring corners say about the print round a corner: corner + e_x a + e_y b + second-order
/// terms is where the board's point (a, b) squares away appears.
struct CornerNeighbourhood {
  Vec2 corner;                                    ///< first estimate, pixels
  Vec2 e_x, e_y;                                  ///< one square along the row and the column
  Vec2 e_xx = Vec2::Zero(), e_yy = Vec2::Zero();  ///< second derivatives: lens and perspective bend the edges
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
  Eigen::Matrix<double, 12, 1> parameters;  ///< of the model, for a further fit to start from
};

/// Of a large window: a coarse raster of its pixels, for whether there is a crossing; a raster, a few
/// hundredths of a pixel off; or every pixel near its edges and a raster of the flat ones, as precise as all
/// of them.
enum class FitEffort { kGlance, kRaster, kFull };

/// nullopt where the window leaves the image or there is no such crossing. A full fit may start from one
/// `before` it.
std::optional<CornerFit> fit_corner(const ViewU8& image, const CornerNeighbourhood& around,
                                    double window_share, FitEffort effort = FitEffort::kFull,
                                    const CornerFit* before = nullptr);

/// A full fit, from an earlier one if there is one `before` it, with one more term of the light: the halo that a camera's sharpening leaves beside
/// edges, c (h(d) - e(d)), where e is the product of the two edges' erf and h the same with a larger blur.
/// c < 0: overshoot; c > 0: a wide skirt.
std::optional<CornerFit> fit_corner_with_halo(const ViewU8& image, const CornerNeighbourhood& around,
                                              double window_share, const CornerFit* before);

}  // namespace procam::detect
