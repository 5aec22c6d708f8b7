#pragma once
/// Convex polygons in a plane, corners in order with the inside to the right of each side in a frame whose y
/// axis points down (top left, top right, bottom right, bottom left).
#include "procam/core/base/types.hpp"

namespace procam::analyze {

/// The points x with normal . x <= offset.
struct HalfPlane {
  Vec2 normal = Vec2::UnitX();
  double offset = 0;
};

/// One a side, normals of unit length pointing outwards.
std::vector<HalfPlane> half_planes(const Points2& polygon);

double area(const Points2& polygon);

/// The part of the polygon inside the half-plane: fewer than three corners when nothing of it is (Sutherland
/// and Hodgman, "Reentrant polygon clipping", 1974).
Points2 clipped(const Points2& polygon, const HalfPlane& half_plane);

/// Centre and width of the largest rectangle inside a convex quadrilateral whose sides are parallel to the
/// axes and whose height is `height_by_width` times its width. Where it could slide, it lies in the middle.
///
/// A rectangle of centre c and width w is inside n . x <= o exactly when
///   n . c + w (|n_x| + |n_y| height_by_width) / 2 <= o;
/// largest w under four such lines is a linear programme in (c, w) whose optimum three of them determine.
struct CentredWidth {
  Vec2 centre = Vec2::Zero();
  double width = 0;
};
CentredWidth largest_rectangle(const Points2& quadrilateral, double height_by_width);

}  // namespace procam::analyze
