#pragma once
/// A room measured by projector and camera: which projector pixel lights each camera pixel -> the depth of what the camera
/// sees there, with its standard deviation.
///
/// A camera pixel's ray is d = (a, b, 1) in the camera's frame, its point z d. The projector sees the point at
///
///   (x, y) = pi(R z d + t),   projector_from_camera = (R, t),   normalised, its lens undone
///
/// and the light says (x, y) = (x_m, y_m) with standard deviations s_x, s_y. The depth is the weighted least-squares
/// solution of these two equations for one unknown,
///
///   z = argmin ((x(z) - x_m) / s_x)^2 + ((y(z) - y_m) / s_y)^2,   1 / sigma^2 = (dx/dz / s_x)^2 + (dy/dz / s_y)^2,
///
/// and what is left of them tells whether column and row meet the camera's ray: chi-square with one degree of freedom
/// when rig and light agree. (Optimal triangulation along one exact ray; Hartley & Zisserman, "Multiple View Geometry",
/// 2nd edition, section 12.5, where both images are uncertain.)
///
/// The error of the rig is common to all pixels: rig_sigma is its part of the depth's standard deviation, to first
/// order, sqrt(g C g^T) with C the rig's covariance and g = dz/d(parameters) for the same light.
#include <cmath>
#include <string>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/geometry/point_cloud.hpp"
#include "procam/core/rig/light_map.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam::scan {

struct ScanOptions {
  /// Pixels whose column and row do not meet the camera's ray, by this many standard deviations, are rejected. Where the rig
  /// is off, all are by a common part: the limit grows with the median over the image.
  double consistency_sigmas = 4;
  double nearest = 0.05, farthest = 50;  ///< depths outside are rejected, metres
  double max_sigma = 0.05;               ///< less certain depths are rejected, metres
  /// Patches of fewer pixels that no depth joins to their neighbours are rejected.
  int min_patch = 40;
  int threads = 0;  ///< 0: as many as the machine has. The result does not depend on it
};

/// Pixels that have light of both axes, and why some of them have no depth.
struct ScanCounts {
  int lit = 0, measured = 0;
  int inconsistent = 0;  ///< column and row do not meet the ray
  int out_of_range = 0;  ///< nearest, farthest, max_sigma, or behind a device
  int isolated = 0;      ///< min_patch
};

/// How the points of a scan move with the rig, to first order. The rig's error is
///
///   theta_used - theta_true = root c,   c ~ N(0, I),   root root^T = the rig's covariance,
///
/// and the measured point of a pixel is the true one + A c, where A (3 rows, a column for each element of c) is stored for the
/// middle of each cell of the image. The vector c is the same for all scans by one rig.
struct RigModes {
  std::vector<std::string> names;  ///< of the rig's parameters, the rows of root
  MatX root;
  int columns = 0, rows = 0;  ///< cells
  /// By cell: depth (0: none), then for each element of c the point's error in the rig's frame (3) and the depth's (1), metres.
  std::vector<float> nodes;

  int count() const { return int(root.cols()); }
};

/// What one camera measured by one projector's light.
struct Scan {
  RigCamera camera;
  std::string projector;  ///< its name
  ImageF depth;           ///< z in the camera's frame, metres; 0: not measured
  ImageF sigma;           ///< of the depth, by the light's noise, metres; 0: not measured
  ImageF rig_sigma;       ///< of the depth, by the rig's covariance, metres; 0: none, or not measured
  RigModes rig_modes;     ///< the same for each parameter of the rig
  ScanCounts counts;
  /// Median of |what is left of column and row| in standard deviations over that of noise alone, 0.674: 1 when the rig and the
  /// light agree.
  double consistency = 1;
  /// Root mean square of the same in projector pixels.
  double consistency_px = 0;
  double consistency_px_of_rig = 0;  ///< the part of it that the rig's covariance predicts; 0: no covariance
  /// Of the depth, by the part that neither the noise nor the rig's covariance explains, metres. Empty where they explain all.
  ImageF misfit_sigma;
  Diagnostics diagnostics;

  bool measured(int x, int y) const { return depth.at(x, y) > 0; }
  /// Of all parts, metres.
  double total_sigma(int x, int y) const {
    const double misfit = misfit_sigma.empty() ? 0 : double(misfit_sigma.at(x, y));
    return std::hypot(double(sigma.at(x, y)), double(rig_sigma.at(x, y)), misfit);
  }
};

/// Where each camera pixel looks: (a, b) with the ray (a, b, 1); NaN where the lens has no inverse.
PROCAM_EXPORT ImageF pixel_rays(const Camera& camera, int threads = 0);

/// `light` is that of the rig's projector `projector` seen by its camera `camera`; empty names for the only ones.
/// Columns and rows of the light that do not meet the camera's rays are "rig_inconsistent": a warning, and a failure above a
/// projector pixel, ten standard deviations of the noise and four of the rig. Then the rig was bumped since its calibration, it is of
/// another session, or the camera moved during the frames. Other warnings: "no_rig_covariance", "few_points".
/// Throws Error(kInput) for a light map of other sizes than the rig's devices and for a name that the rig does not have, Error(kDegenerate) for camera and projector in one place,
/// Error(kNotEnoughData) when no pixel has a depth, and when nothing fits (2 % of the projector frame's diagonal); the message gives
/// the reason, and names mirrored or rotated images.
PROCAM_EXPORT Scan measure_depth(const LightMap& light, const Rig& rig, const std::string& camera = "",
                                 const std::string& projector = "", const ScanOptions& options = {});

/// The measured points in the rig's frame, row by row, with normals from the neighbours within three pixels and the total
/// standard deviation along the camera's ray.
PROCAM_EXPORT PointCloud point_cloud(const Scan& scan);

}  // namespace procam::scan
