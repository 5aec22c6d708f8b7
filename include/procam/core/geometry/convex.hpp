#pragma once
/// Convex polygons in a plane, corners in order with the inside to the right of each side in a frame whose y
/// axis points down (top left, top right, bottom right, bottom left).
#include <Eigen/Geometry>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/types.hpp"

namespace procam {

/// The points x with normal . x <= offset.
struct HalfPlane {
  Vec2 normal = Vec2::UnitX();
  double offset = 0;
};

/// One a side, normals of unit length pointing outwards.
PROCAM_EXPORT std::vector<HalfPlane> half_planes(const Points2& polygon);

PROCAM_EXPORT double area(const Points2& polygon);

/// The part of the polygon inside the half-plane: fewer than three corners when nothing of it is (Sutherland
/// and Hodgman, "Reentrant polygon clipping", 1974).
PROCAM_EXPORT Points2 clipped(const Points2& polygon, const HalfPlane& half_plane);

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/geometry/detail/convex_body.hpp"
#endif
