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
#include "procam/core/base/export.hpp"
#include "procam/core/lens/intrinsics.hpp"

namespace procam {

/// glFrustum's six numbers, metres.
struct Frustum {
  double left = 0, right = 0, bottom = 0, top = 0, near = 0, far = 0;
};

namespace internal {
/// Throws std::invalid_argument for an image, focal lengths or clip planes that give no frustum.
PROCAM_EXPORT void require_frustum(const Intrinsics& k, ImageSize size, double near, double far);
}  // namespace internal

/// The six numbers for intrinsics without skew. Throws std::invalid_argument for skew != 0: use
/// clip_from_eye().
PROCAM_EXPORT Frustum frustum(const Intrinsics& k, ImageSize size, double near, double far);

enum class GraphicsApi {
  kOpenGL,   ///< eye x right, y up, z backward; clip y up, depth -1..1
  kVulkan,   ///< eye = optical frame, x right, y down, z forward; clip y down, depth 0..1
  kDirect3D  ///< eye x right, y up, z forward (left-handed); clip y up, depth 0..1
};

/// Eye frame of the API from procam's optical frame (x right, y down, z forward): a change of axis signs.
PROCAM_EXPORT Mat4 eye_from_optical(GraphicsApi api);

/// The 4x4 matrix (column vectors: clip = M * point) from the optical frame to the API's clip space.
PROCAM_EXPORT Mat4 clip_from_optical(const Intrinsics& k, ImageSize size, double near, double far,
                                     GraphicsApi api);

/// The projection matrix as the API's users know it: from its own eye frame to its clip space.
PROCAM_EXPORT Mat4 clip_from_eye(const Intrinsics& k, ImageSize size, double near, double far,
                                 GraphicsApi api);

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/lens/detail/frustum_body.hpp"
#endif
