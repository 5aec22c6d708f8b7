#pragma once
/// Choosing and changing the lens model of a camera.
#include <limits>

#include "procam/calibrate/bundle.hpp"
#include "procam/calibrate/lens_model.hpp"

namespace procam::calibrate {

/// What a lens may be, from the fewest terms to the most: none; k1,k2; k1,k2,k3; k1,k2,p1,p2; all five (the
/// usual); rational; for a camera that sees further than 35 degrees off its axis, fisheye. Skew is estimated
/// in all of them.
std::vector<LensModel> candidate_lens_models(const Camera& lens, DeviceKind kind);

/// The same lens in another model, near enough to begin with: coefficients of the same name are kept, a
/// fisheye's follow the lens's radial profile by least squares.
Camera in_model(const Camera& lens, const LensModel& model);

/// The share of a 17 x 17 grid of the picture's pixels that are within `reach` pixels of the principal point
/// and where the lens model has no inverse.
double folded_share(const Camera& lens, double reach = std::numeric_limits<double>::infinity());

/// How far from the principal point the lens is used, pixels: the farthest used point and a tenth more, about
/// the square of a board between its outermost corners and its border. Beyond it an image may be empty.
double reach_of(const Correspondences& data, const UsedMask& used, std::size_t device, const Camera& lens);

}  // namespace procam::calibrate
