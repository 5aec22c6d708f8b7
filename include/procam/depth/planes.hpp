#pragma once
/// Planes in a depth image, how well each is known, and what is curved instead.
///
/// A plane is linear in inverse depth: the point z (u, v, 1) lies on normal . x + offset = 0 when
///
///   1 / z = t . (u, v, 1),   t = -normal / offset
///
/// so that axial noise is the noise of a linear regression with weights 1 / (sigma(z) / z^2)^2, whose
/// solution is unbiased (a fit of perpendicular distances is not) and whose covariance is the inverse of its
/// normal matrix. Quantised disparities are evenly spaced there as well.
///
/// 1  moments of cells of 8 x 8 pixels; cells that no plane fits are skipped
/// 2  regions grow from the flattest blocks of 3 x 3 cells: a cell joins when its mean and slopes agree with
///    the region's plane within noise; parts of one plane are joined
/// 3  curved regions are found by the second-order part of their residuals, and joined into cylinders and
///    spheres where one explains them
/// 4  planes are fitted to cells that have no other surface beside them; borders are settled pixel by pixel
///
/// Where the image shows that errors of neighbouring readings average (white noise, not quantised), limits
/// are by the measured noise; cells at the end of the range are rejected, since their farther readings are
/// missing; and a plane is rejected whose normal the readings do not determine to 5 degrees (two sigmas), or
/// whose residuals have a structure that may rotate it by 7.5 degrees (a strip that mixes two surfaces).
///
/// Region growing on cells in the spirit of P. F. Proenca, Y. Gao, "Fast cylinder and plane extraction from
/// depth cameras for visual odometry" (CAPE), IROS 2018. The same image gives the same planes, bit for bit.
#include <variant>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/plane.hpp"
#include "procam/core/surface/cylinder.hpp"
#include "procam/core/surface/sphere.hpp"
#include "procam/depth/depth_image.hpp"
#include "procam/depth/ray_table.hpp"

namespace procam::depth {

/// A plane and the covariance of (normal, offset). It has rank 3, nothing along the normal: two directions of
/// the normal (radians) and the offset (metres).
struct PlaneEstimate {
  Plane plane;
  Mat4 covariance = Mat4::Zero();
};

/// How far `truth` is from the estimate: e^T C^-1 e over the three directions, chi-square with 3 degrees of
/// freedom when the covariance is right (7.81 bounds 95 %).
PROCAM_EXPORT double squared_sigmas(const PlaneEstimate& estimate, const Plane& truth);

struct PlaneOptions {
  DepthNoise noise = DepthNoise::kinect_v1();
  double nearest = 0.2, farthest = 8;  ///< readings outside are ignored, metres
  double min_area = 0.04;              ///< square metres; what is smaller is no surface to project on
  int min_cells = 9;                   ///< of 8 x 8 pixels: fewer do not determine the normal
  /// RMS of a region's second-order residual, in sigmas of what readings share (DepthNoise), from which it
  /// may be curved: it is where a cylinder or sphere that turns by 12 degrees or more explains it better.
  /// Three times as much is curved in any case. Lower finds flatter curves, and then takes the depth camera's
  /// own distortion for one.
  double curvature_threshold = 0.45;
};

struct DetectedPlane {
  PlaneEstimate estimate;  ///< camera frame, the normal towards the camera (offset > 0)
  int pixels = 0;          ///< that bear its label
  double area = 0;         ///< square metres that these cover
  double rms = 0;          ///< of the readings, perpendicular to the plane, metres
  /// The part of `rms` that the sensor's noise explains: as predicted by the model, or as measured where the
  /// readings vary more than it predicts (Planes::noise_ratio).
  double noise_rms = 0;
  /// Variance found over variance assumed, already part of the covariance. Far above 1: the surface is not
  /// flat, or its readings share errors.
  double noise_factor = 1;
  Vec3 middle = Vec3::Zero();  ///< of its pixels, on the plane
};

/// A part of a cylinder or of a sphere, in the camera's frame; `frame` of the surface is left at its default.
struct DetectedCurve {
  std::variant<CylinderSurface, SphereSurface> shape;
  int pixels = 0;
  double rms = 0;  ///< of cells of pixels, perpendicular, metres
};

struct Planes {
  std::vector<DetectedPlane> planes;  ///< the largest in pixels first
  std::vector<DetectedCurve> curves;
  /// Places in `planes`, then planes.size() + places in `curves`; kCurved: curved, but no simple shape fits;
  /// kNone: no surface; kNothing: no reading.
  Image<std::int16_t> labels;
  static constexpr std::int16_t kNothing = -1, kNone = -2, kCurved = -3;
  /// Measured noise over that of PlaneOptions::noise: the residual RMS of cells of 8 x 8 pixels about their
  /// own planes, in sigmas, at the lower quartile over the image (scaled to 1 for white noise), so that
  /// edges and clutter do not count. 0.6 to 1.1 when the model suits the sensor: quantised readings vary less
  /// within a cell. Above 1.2 the planes were found with the measured noise. 0: not enough readings.
  double noise_ratio = 0;
};

/// Throws std::invalid_argument for an image that is not of the camera's size or options out of range. An
/// image without a reading has no planes.
PROCAM_EXPORT Planes find_planes(const DepthImage& image, const RayTable& rays,
                                 const PlaneOptions& options = {});

/// Planes::noise_ratio of the image for another noise model: which kind of sensor took it.
PROCAM_EXPORT double noise_ratio(const DepthImage& image, const RayTable& rays, const DepthNoise& noise);

}  // namespace procam::depth
