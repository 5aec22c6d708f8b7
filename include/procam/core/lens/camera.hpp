#pragma once
/// A camera: image size, intrinsic matrix, lens distortion. Optical frame: x right, y down, z forward.
///
///   pixel = K * distort(point),   bearing = undistort(K^-1 * pixel) / |.|
///
/// project<Model, T> is the one formula: double here, Jet in the cost functors, the renderers' per-pixel
/// code.
#include "procam/core/base/export.hpp"
#include "procam/core/lens/distortion.hpp"
#include "procam/core/lens/intrinsics.hpp"

namespace procam {

/// Point in the optical frame -> pixel; nullopt behind the lens or beyond the lens model's fold. Never NaN.
template <typename Model, typename T>
std::optional<Vec2T<T>> project(const IntrinsicsT<T>& intrinsics, const T* coefficients,
                                const Vec3T<T>& point) {
  const std::optional<Vec2T<T>> distorted = Model::distort(coefficients, point);
  if (!distorted) return std::nullopt;
  const Vec2T<T> pixel = intrinsics.pixel_from_normalized(*distorted);
  if (!is_finite(pixel)) return std::nullopt;
  return pixel;
}

struct Camera {
  ImageSize size;
  Intrinsics intrinsics;
  Distortion distortion;

  /// Point in the optical frame (metres) -> pixel, which may lie outside the image; nullopt when the lens
  /// cannot see it.
  PROCAM_EXPORT std::optional<Vec2> project(const Vec3& point_in_camera) const;

  /// Pixel -> unit bearing in the optical frame; nullopt where the lens model has no inverse.
  PROCAM_EXPORT std::optional<Vec3> unproject(const Vec2& pixel) const;

  /// Does the point fall on the image?
  bool sees(const Vec3& point_in_camera) const {
    const std::optional<Vec2> pixel = project(point_in_camera);
    return pixel && size.contains(*pixel);
  }
};

/// Names of all parameters in the order of files and covariances: fx fy cx cy skew, then the model's
/// coefficients.
PROCAM_EXPORT std::vector<std::string> parameter_names(const Camera& camera);

PROCAM_EXPORT VecX parameters_of(const Camera& camera);

/// The same camera (size, distortion model) with other parameters, in the order of parameter_names().
PROCAM_EXPORT Camera with_parameters(Camera camera, const VecX& parameters);

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/lens/detail/camera_body.hpp"
#endif
