#pragma once
/// Choosing and changing the lens model of a camera.
#include "procam/calibrate/lens_model.hpp"

namespace procam::calibrate {

/// What a lens may be, from the fewest terms to the most: none; k1,k2; k1,k2,k3; k1,k2,p1,p2; all five (the
/// usual); rational; for a camera that sees further than 35 degrees off its axis, fisheye. Skew is estimated
/// in all of them.
std::vector<LensModel> candidate_lens_models(const Camera& lens, DeviceKind kind);

/// The same lens in another model, near enough to begin with: coefficients of the same name are kept, a
/// fisheye's follow the lens's radial profile by least squares.
Camera in_model(const Camera& lens, const LensModel& model);

/// Does the lens model have an inverse on every pixel of the picture (to a 17 x 17 grid of them)?
bool is_monotone(const Camera& lens);

}  // namespace procam::calibrate
