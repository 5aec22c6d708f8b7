#pragma once
/// The bodies of homography.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include <string>

#include "procam/core/base/error.hpp"
#include "procam/core/geometry/homography.hpp"

namespace procam::detail {

[[noreturn]] PROCAM_CORE_INLINE void refuse_four(const std::array<Vec2, 4>& source,
                                                 const std::array<Vec2, 4>& destination,
                                                 const std::array<int, 4>& index, double tolerance) {
  const std::string what = "homography from 4 points";
  // Triangle i omits point i. Only products of a source and a destination area count: order is free.
  constexpr int kOthers[4][3] = {{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}};
  const auto area = [&](const std::array<Vec2, 4>& p, int i) {
    const Vec2 side1 = p[kOthers[i][1]] - p[kOthers[i][0]], side2 = p[kOthers[i][2]] - p[kOthers[i][0]];
    return side1.x() * side2.y() - side1.y() * side2.x();
  };
  const auto name = [&](int i) { return std::to_string(index[i]); };
  for (const bool in_source : {true, false}) {
    const std::array<Vec2, 4>& points = in_source ? source : destination;
    const std::string side = in_source ? "source" : "destination";
    for (int i = 0; i < 4; ++i)
      if (!points[i].allFinite())
        throw Error(ErrorKind::kInput, what, side + " point " + name(i) + " is not finite",
                    "remove it or measure it again");
    double squared_size = 0.0;
    for (int i = 0; i < 3; ++i) squared_size = std::max(squared_size, (points[i] - points[3]).squaredNorm());
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j)
        if ((points[i] - points[j]).norm() <= tolerance * std::sqrt(squared_size))
          throw Error(ErrorKind::kDegenerate, what,
                      side + " points " + name(i) + " and " + name(j) + " coincide",
                      "give four distinct points");
    for (int i = 0; i < 4; ++i) {
      const int a = kOthers[i][0], b = kOthers[i][1], c = kOthers[i][2];
      if (!(std::abs(area(points, i)) > tolerance * squared_size))
        throw Error(ErrorKind::kDegenerate, what,
                    side + " points " + name(a) + ", " + name(b) + " and " + name(c) + " lie on one line",
                    "move one of them off the line: no three of the four may be collinear");
    }
  }
  const auto on_first_side = [&](int i) {
    return (area(source, i) * area(destination, i) > 0.0) == (area(source, 0) * area(destination, 0) > 0.0);
  };
  std::string front, behind;
  for (int i = 0; i < 4; ++i) {
    std::string& side = on_first_side(i) ? front : behind;
    side += (side.empty() ? "" : ", ") + name(i);
  }
  throw Error(
      ErrorKind::kDegenerate, what,
      "the horizon separates point(s) " + front + " from point(s) " + behind +
          ": one of the two figures is convex where the other is not, or the order of the points differs",
      "check that both lists name the same points in the same order");
}

}  // namespace procam::detail
// NOLINTEND(misc-definitions-in-headers)
