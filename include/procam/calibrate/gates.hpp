#pragma once
/// Quality checks that a rig must pass at any RMS. A small residual is no proof: a
/// focal length wrong by two has been published with an RMS of 0.86.
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam::calibrate {

/// Limits with their reasons. Real devices lie well inside; a wrong solution rarely does.
struct GateLimits {
  double max_rms_px =
      0.5;                 ///< corners are found to 0.1 px, decoded light to 0.1 px: more means a wrong model
  double min_fov_deg = 4;  ///< across the picture; long-throw lenses end near 5 degrees
  double max_fov_deg = 140;
  double max_aspect_error =
      0.04;  ///< |fx/fy - 1|: sensors and DMDs have square pixels (1.6 % non-square DMDs exist)
  double max_lens_shift = 1.0;   ///< principal point from the picture's centre, in picture widths / heights
  double max_tangential = 0.01;  ///< |p1|, |p2|: a hundredth tilts the lens by half a degree
  double max_camera_offset = 0.15;   ///< camera's principal point from its centre, in widths / heights
  double max_relative_sigma = 0.02;  ///< sigma of fx, fy over their value
  double max_holdout_ratio = 3;      ///< held-out error over the fit's RMS: more is over-fitting ...
  /// ... unless the rig's sigmas explain it. Few views predict another one badly, and their sigmas are as
  /// large. Held-out error over the expected one: 0.8 to 1.35 in 68 sound numeric sessions of 4 to 12 views,
  /// at most 1.9 in 84 with shifted views or a bent board (2 of them above 1.5), up to 3 where the lens has
  /// distortion that the model lacks.
  double max_holdout_sigmas = 1.5;
};

/// The quality checks of a rig that was read from a file, and the checks in the file that only its calibration
/// could make (views that disagree, broken captures): a rig that failed one of them stays marked. The check
/// on the predicted error is not among them, since it depends on the wall and the accepted error.
PROCAM_EXPORT std::vector<Gate> check_stored_rig(const Rig& rig, const GateLimits& limits = {});

}  // namespace procam::calibrate
