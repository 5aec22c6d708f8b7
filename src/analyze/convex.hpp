#pragma once
/// Rectangles in convex quadrilaterals.
#include "procam/core/geometry/convex.hpp"

namespace procam::analyze {

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
