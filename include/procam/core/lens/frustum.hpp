#pragma once
/// From intrinsics to the projection matrix of a rendering camera, exact with skew and an off-centre
/// principal point.
///
/// With pixel centres at integers the image spans [-1/2, W-1/2] x [-1/2, H-1/2], so at distance `near`:
///   left = -near (cx + 1/2) / fx,        right  = near (W - cx - 1/2) / fx,
///   top  =  near (cy + 1/2) / fy,        bottom = -near (H - cy - 1/2) / fy.
/// Skew adds -2 skew / W at row 0, column 1 of OpenGL's matrix, which glFrustum's six numbers cannot express:
/// the 4x4 matrix is the primary form. Dropping the halves would shift the picture by half a pixel. Lens
/// distortion is not linear and has no place in a matrix: see render for the full model.
#include <cmath>

#include "procam/core/base/error.hpp"
#include "procam/core/lens/intrinsics.hpp"

namespace procam {

/// glFrustum's six numbers, metres.
struct Frustum {
  double left = 0, right = 0, bottom = 0, top = 0, near = 0, far = 0;
};

namespace internal {
inline void require_frustum(const Intrinsics& k, ImageSize size, double near, double far) {
  require(size.width > 0 && size.height > 0, "frustum: empty image");
  require(k.fx > 0 && k.fy > 0 && k.matrix().allFinite(),
          "frustum: focal lengths must be positive and all intrinsics finite");
  require(near > 0 && far > near && std::isfinite(far), "frustum: need 0 < near < far < infinity");
}
}  // namespace internal

/// The six numbers for intrinsics without skew. Throws std::invalid_argument for skew != 0: use
/// clip_from_eye().
inline Frustum frustum(const Intrinsics& k, ImageSize size, double near, double far) {
  internal::require_frustum(k, size, near, far);
  require(k.skew == 0, "frustum: glFrustum cannot express skew; use clip_from_eye()");
  return {-near * (k.cx + 0.5) / k.fx,
          near * (size.width - k.cx - 0.5) / k.fx,
          -near * (size.height - k.cy - 0.5) / k.fy,
          near * (k.cy + 0.5) / k.fy,
          near,
          far};
}

enum class GraphicsApi {
  kOpenGL,   ///< eye x right, y up, z backward; clip y up, depth -1..1
  kVulkan,   ///< eye = optical frame, x right, y down, z forward; clip y down, depth 0..1
  kDirect3D  ///< eye x right, y up, z forward (left-handed); clip y up, depth 0..1
};

/// Eye frame of the API from procam's optical frame (x right, y down, z forward): a change of axis signs.
inline Mat4 eye_from_optical(GraphicsApi api) {
  Vec4 signs(1, 1, 1, 1);
  if (api == GraphicsApi::kOpenGL) signs = Vec4(1, -1, -1, 1);
  if (api == GraphicsApi::kDirect3D) signs = Vec4(1, -1, 1, 1);
  return signs.asDiagonal();
}

/// The 4x4 matrix (column vectors: clip = M * point) from the optical frame to the API's clip space.
inline Mat4 clip_from_optical(const Intrinsics& k, ImageSize size, double near, double far, GraphicsApi api) {
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

/// The projection matrix as the API's users know it: from its own eye frame to its clip space.
inline Mat4 clip_from_eye(const Intrinsics& k, ImageSize size, double near, double far, GraphicsApi api) {
  return clip_from_optical(k, size, near, far, api) *
         eye_from_optical(api);  // the sign changes are their own inverse
}

}  // namespace procam
