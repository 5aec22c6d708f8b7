#pragma once
/// The last step of circle detection: a blurred dark ellipse. Equation in detect/circle_grid.hpp.
#include <optional>

#include "procam/core/base/image.hpp"
#include "procam/core/base/types.hpp"

namespace procam::detect {

struct DiscGuess {
  Vec2 centre;
  Mat2 shape;                      ///< A: r^T A r = 1 on the rim, 1 / pixel^2
  double inside = 3, outside = 3;  ///< pixels used on both sides of the rim
};

struct DiscFit {
  Vec2 centre;
  Mat2 shape;
  Mat2 covariance;  ///< of the centre, pixel^2
  double contrast = 0, blur = 0, residual = 0;
};

/// nullopt where the window leaves the image or there is no such disc.
std::optional<DiscFit> fit_disc(const ViewU8& image, const DiscGuess& guess);

}  // namespace procam::detect
