#pragma once
/// How far a scan is off where the truth is known: of simulated rooms, and of surfaces measured otherwise.
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/point_cloud.hpp"
#include "procam/scan/scan.hpp"

namespace procam::scan {

struct ScanError {
  int compared = 0;  ///< measured pixels with a true depth
  double rms =
      0;  ///< along the true surface's normal, metres; without outliers, unless they are more than half
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

/// Depths that a camera would measure without error.
struct TrueView {
  Camera camera;
  Pose world_from_camera;
  ImageF depth;  ///< metres, 0: unknown
};

/// Points in the world, whose sigma is along the normal, against the true surfaces that the views see. A point is compared with the
/// view whose surface is nearest to it, along the true surface's normal; within two pixels of a step either side counts. Points that no
/// view sees are not compared. Throws Error(kNotEnoughData) when there are no others, std::invalid_argument for a cloud without sigmas.
PROCAM_EXPORT ScanError compare(const PointCloud& cloud, const std::vector<TrueView>& truth);

}  // namespace procam::scan
