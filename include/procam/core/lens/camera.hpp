#pragma once
/// A camera: image size, intrinsic matrix, lens distortion. Optical frame: x right, y down, z forward.
///
///   pixel = K * distort(point),   bearing = undistort(K^-1 * pixel) / |.|
///
/// project<Model, T> is the one formula: double here, Jet in the cost functors, the renderers' per-pixel
/// code.
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
  std::optional<Vec2> project(const Vec3& point_in_camera) const {
    return std::visit(
        [&](const auto& model) -> std::optional<Vec2> {
          return procam::project<std::decay_t<decltype(model)>>(intrinsics, model.coefficients.data(),
                                                                point_in_camera);
        },
        distortion);
  }

  /// Pixel -> unit bearing in the optical frame; nullopt where the lens model has no inverse.
  std::optional<Vec3> unproject(const Vec2& pixel) const {
    const Vec2 distorted = intrinsics.normalized_from_pixel(pixel);
    const std::optional<Vec3> direction = std::visit(
        [&](const auto& model) {
          return std::decay_t<decltype(model)>::undistort(model.coefficients.data(), distorted);
        },
        distortion);
    if (!direction) return std::nullopt;
    return Vec3(direction->stableNormalized());  // its square may overflow where the direction does not
  }

  /// Does the point fall on the image?
  bool sees(const Vec3& point_in_camera) const {
    const std::optional<Vec2> pixel = project(point_in_camera);
    return pixel && size.contains(*pixel);
  }
};

/// Names of all parameters in the order of files and covariances: fx fy cx cy skew, then the model's
/// coefficients.
inline std::vector<std::string> parameter_names(const Camera& camera) {
  std::vector<std::string> names(kIntrinsicsNames.begin(), kIntrinsicsNames.end());
  for (const std::string& name : coefficient_names(camera.distortion)) names.push_back(name);
  return names;
}

inline VecX parameters_of(const Camera& camera) {
  const auto k = camera.intrinsics.to_array();
  const std::vector<double> c = coefficients_of(camera.distortion);
  VecX p(k.size() + c.size());
  for (std::size_t i = 0; i < k.size(); ++i) p[Eigen::Index(i)] = k[i];
  for (std::size_t i = 0; i < c.size(); ++i) p[Eigen::Index(k.size() + i)] = c[i];
  return p;
}

/// The same camera (size, distortion model) with other parameters, in the order of parameter_names().
inline Camera with_parameters(Camera camera, const VecX& parameters) {
  require(std::size_t(parameters.size()) == parameter_names(camera).size(),
          "with_parameters: wrong number of parameters");
  camera.intrinsics = Intrinsics::from_array(parameters.data());
  camera.distortion =
      with_coefficients(camera.distortion, std::vector<double>(parameters.data() + Intrinsics::kNumParameters,
                                                               parameters.data() + parameters.size()));
  return camera;
}

}  // namespace procam
