#pragma once
/// Lens models as people name them, and the ladder of them that a calibration may choose from.
#include <string>
#include <vector>

#include "procam/core/lens/camera.hpp"
#include "procam/core/rig/observation.hpp"

namespace procam::calibrate {

/// A distortion, and which of its coefficients are estimated.
struct LensModel {
  std::string name;  ///< "none", "brown-conrady:k1,k2", "rational", "fisheye"
  Distortion distortion;
  std::vector<std::string> held;  ///< coefficients that stay zero

  int terms() const { return int(coefficient_names(distortion).size()) - int(held.size()); }
};

/// All five terms, within what is known of any lens (lens_prior.hpp): serves nearly every lens.
inline constexpr char kUsualLensModel[] = "brown-conrady:k1,k2,p1,p2,k3";
/// The same without p1,p2.
inline constexpr char kWithoutTangential[] = "brown-conrady:k1,k2,k3";

/// The model of a name: a distortion's, with the estimated coefficients after a colon where not all of them
/// are ("brown-conrady:k1,k2"). "brown-conrady" alone is k1,k2,p1,p2. Throws Error(kUnsupported)
/// for another distortion, Error(kInput) for a coefficient that it lacks.
LensModel lens_model_named(const std::string& name);

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
