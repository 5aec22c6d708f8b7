#pragma once
/// How far a scan is off where the truth is known: of simulated rooms, and of surfaces measured otherwise.
#include "procam/core/base/export.hpp"
#include "procam/scan/scan.hpp"

namespace procam::scan {

struct ScanError {
  int compared = 0;   ///< measured pixels with a true depth
  double rms = 0;     ///< along the true surface's normal, without outliers, metres
  double median = 0;  ///< of its absolute value
  double expected_rms =
      0;                 ///< what the stated standard deviations (noise and rig) predict for the same pixels
  double noise_rms = 0;  ///< the part of that by the light's noise
  double inside_3_sigma = 0;  ///< share of the pixels within three total standard deviations
  double outliers = 0;  ///< share that is off by more than 10 mm, and by more than ten standard deviations
};

/// Depths against `true_depth` (metres, 0: unknown), pixel by pixel. Within two pixels of a step in the true depth either
/// side counts as true: where the border of a surface lies within a pixel is no error of its depth. Throws
/// std::invalid_argument for another size, Error(kNotEnoughData) when no pixel has both depths.
PROCAM_EXPORT ScanError compare(const Scan& scan, ViewF true_depth);

}  // namespace procam::scan
