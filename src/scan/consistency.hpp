#pragma once
/// Do the light and the rig belong together? Column and row of a pixel must meet its ray to within the light's noise and the rig's
/// covariance.
#include <string>

#include "depth_solver.hpp"
#include "procam/core/rig/light_map.hpp"
#include "procam/scan/scan.hpp"

namespace procam::scan {

/// Depths, and what is left of each pixel's equations; `left` is -1 where there is no light.
struct RawDepths {
  ImageF left, left_px, by_px;  ///< as in Depth
};

/// Sets `consistency` and `consistency_px`, before any pixel is rejected.
void measure_consistency(const RawDepths& raw, Scan& scan);

/// Sets `misfit_sigma` from them and `consistency_px_of_rig`.
void set_misfit_sigma(const RawDepths& raw, Scan& scan);

/// Remark or failure "rig_inconsistent". Throws Error(kNotEnoughData) where nothing fits.
void check_consistency(const LightMap& light, const DepthSolver& solver, const ImageF& rays, Scan& scan);

/// How the images would have to be changed for the light to fit, e.g. "rotated by 180 degrees"; empty where no change fits much
/// better.
std::string image_change(const LightMap& light, const DepthSolver& solver, const ImageF& rays);

}  // namespace procam::scan
