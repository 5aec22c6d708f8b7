#pragma once
/// A whole marker fitted to its pixels at once: for markers whose cells are too small for edges of their own.
///
///   I(p) = (1 + l . (p - p0)) 255 (a + b (W(p) - e E(p)))^g
///
/// W(p): the share of white under a Gaussian of sigma s about the pixel, of the known cells on white paper,
/// seen through the warp (a homography, then the lens), which counts as affine over the blur. E(p): by how
/// much W falls when all borders move towards white by one cell (ink; what gamma leaves). Unknown: the four
/// corners, s, the light (a, b and its slope l), the camera's gamma g, and e. Every pixel's noise is a
/// straight line over its level, estimated from the residuals (a camera's gamma makes it largest in the
/// dark).
///
/// In the cells' own axes the blur is an ellipse. Its covariance is that of two independent axes and of a
/// line, C = diag(c) + v v^T; over the axes W is a sum of products of normal distributions, over the line a
/// Gauss-Hermite quadrature.
#include "marker_warp.hpp"

namespace procam::detect {

struct ModelFit {
  std::array<Vec2, 4> corners;
  Eigen::Matrix<double, 8, 8> covariance;  ///< of the corners, everything else estimated as well
};

/// From corners that are right to about a pixel; nullopt where the image does not show this marker well
/// enough: the residuals are more than 12 % of the contrast, a corner's sigma is above half a pixel, or it
/// lies at the image's border.
std::optional<ModelFit> fit_model(const ViewU8& image, const MarkerCells& codes, int id,
                                  const std::array<Vec2, 4>& start, const Camera* lens);

}  // namespace procam::detect
