#pragma once
/// The bodies of frustum.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include <cmath>

#include "procam/core/base/error.hpp"
#include "procam/core/lens/frustum.hpp"

namespace procam {

namespace internal {
PROCAM_CORE_INLINE void require_frustum(const Intrinsics& k, ImageSize size, double near, double far) {
  require(size.width > 0 && size.height > 0, "frustum: empty image");
  require(k.fx > 0 && k.fy > 0 && k.matrix().allFinite(),
          "frustum: focal lengths must be positive and all intrinsics finite");
  require(near > 0 && far > near && std::isfinite(far), "frustum: need 0 < near < far < infinity");
}
}  // namespace internal

PROCAM_CORE_INLINE Frustum frustum(const Intrinsics& k, ImageSize size, double near, double far) {
  internal::require_frustum(k, size, near, far);
  require(k.skew == 0, "frustum: glFrustum cannot express skew; use clip_from_eye()");
  return {-near * (k.cx + 0.5) / k.fx,
          near * (size.width - k.cx - 0.5) / k.fx,
          -near * (size.height - k.cy - 0.5) / k.fy,
          near * (k.cy + 0.5) / k.fy,
          near,
          far};
}

PROCAM_CORE_INLINE Mat4 eye_from_optical(GraphicsApi api) {
  Vec4 signs(1, 1, 1, 1);
  if (api == GraphicsApi::kOpenGL) signs = Vec4(1, -1, -1, 1);
  if (api == GraphicsApi::kDirect3D) signs = Vec4(1, -1, 1, 1);
  return signs.asDiagonal();
}

PROCAM_CORE_INLINE Mat4 clip_from_optical(const Intrinsics& k, ImageSize size, double near, double far,
                                          GraphicsApi api) {
  internal::require_frustum(k, size, near, far);
  const double w = size.width, h = size.height;
  const double y =
      api == GraphicsApi::kVulkan ? 1 : -1;  // pixel rows grow downwards; OpenGL's and D3D's clip y upwards
  Mat4 m = Mat4::Zero();
  m.row(0) << 2 * k.fx / w, 2 * k.skew / w, 2 * (k.cx + 0.5) / w - 1, 0;
  m.row(1) << 0, y * 2 * k.fy / h, y * (2 * (k.cy + 0.5) / h - 1), 0;
  if (api == GraphicsApi::kOpenGL) {
    m.row(2) << 0, 0, (far + near) / (far - near), -2 * far * near / (far - near);
  } else {
    m.row(2) << 0, 0, far / (far - near), -far * near / (far - near);
  }
  m.row(3) << 0, 0, 1, 0;
  return m;
}

PROCAM_CORE_INLINE Mat4 clip_from_eye(const Intrinsics& k, ImageSize size, double near, double far,
                                      GraphicsApi api) {
  return clip_from_optical(k, size, near, far, api) *
         eye_from_optical(api);  // the sign changes are their own inverse
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
