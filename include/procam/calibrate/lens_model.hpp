#pragma once
/// Lens models as people name them, and the ladder of them that a calibration may choose from.
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
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
PROCAM_EXPORT LensModel lens_model_named(const std::string& name);

}  // namespace procam::calibrate
