#pragma once
/// Content position -> projector pixel, for each way a surface may be placed.
#include "procam/core/geometry/homography.hpp"
#include "procam/core/lens/projector.hpp"
#include "procam/core/surface/surface.hpp"

namespace procam::surface {

/// The pixel whose light shows a place of the content (it may lie outside the picture); nullopt where no
/// light can go.
inline std::optional<Vec2> lighting_pixel(const Projector&, const PlacedPixels& placed, const Vec2& uv) {
  return pixel_at(placed, uv);
}
inline std::optional<Vec2> lighting_pixel(const Projector& projector, const PlacedPlane& placed,
                                          const Vec2& uv) {
  const std::optional<Vec2> p = Homography(placed.plane_from_content).apply(uv);
  if (!p) return std::nullopt;
  return projector.project(placed.projector_from_surface * Vec3(p->x(), p->y(), 0));
}

}  // namespace procam::surface
