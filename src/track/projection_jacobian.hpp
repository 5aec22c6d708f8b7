#pragma once
/// d pixel / d point of a camera's full lens model.
#include <algorithm>
#include <array>
#include <optional>
#include <type_traits>
#include <variant>

#include "procam/core/base/dual.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam::track::internal {

/// The point in the camera's frame; nullopt where the lens cannot see it.
inline std::optional<Mat23> projection_jacobian(const Camera& camera, const Vec3& point) {
  using D = Dual<3>;
  const IntrinsicsT<D> k{camera.intrinsics.fx, camera.intrinsics.fy, camera.intrinsics.cx,
                         camera.intrinsics.cy, camera.intrinsics.skew};
  const Vec3T<D> variable(D(point.x(), 0), D(point.y(), 1), D(point.z(), 2));
  const auto pixel = std::visit(
      [&](const auto& model) {
        using Model = std::decay_t<decltype(model)>;
        std::array<D, std::tuple_size_v<decltype(model.coefficients)> + 1> coefficients;
        std::copy(model.coefficients.begin(), model.coefficients.end(), coefficients.begin());
        return project<Model>(k, coefficients.data(), variable);
      },
      camera.distortion);
  if (!pixel) return std::nullopt;
  Mat23 jacobian;
  jacobian << pixel->x().v.transpose(), pixel->y().v.transpose();
  return jacobian;
}

}  // namespace procam::track::internal
