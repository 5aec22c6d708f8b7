#pragma once
/// The bodies of homography.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "procam/core/base/error.hpp"
#include "procam/core/geometry/homography.hpp"

namespace procam {

PROCAM_CORE_INLINE Homography::Homography(const Mat3& matrix) : matrix_(matrix) {
  const double determinant = matrix.determinant();
  if (!std::isfinite(determinant) || determinant == 0.0)
    throw std::invalid_argument("Homography: the matrix is singular or not finite");
}

PROCAM_CORE_INLINE Homography Homography::normalised() const {
  return Homography(Mat3(matrix_ / matrix_.norm()));
}

PROCAM_CORE_INLINE Mat2 Homography::jacobian(const Vec2& source) const {
  return (matrix_.topLeftCorner<2, 2>() - apply_unchecked(source) * matrix_.bottomLeftCorner<1, 2>()) /
         denominator(source);
}

PROCAM_CORE_INLINE Mat29 Homography::jacobian_of_entries(const Vec2& source) const {
  const Eigen::RowVector3d s = Vec3(source.x(), source.y(), 1.0).transpose() / denominator(source);
  const Vec2 mapped = apply_unchecked(source);
  Mat29 jacobian;
  jacobian << s, Eigen::RowVector3d::Zero(), -mapped.x() * s, Eigen::RowVector3d::Zero(), s, -mapped.y() * s;
  return jacobian;
}

PROCAM_CORE_INLINE bool Homography::mirrors() const {
  return matrix_.determinant() < 0.0;
}

PROCAM_CORE_INLINE Homography Homography::inverse() const {
  return Homography(Mat3(matrix_.inverse()));
}

PROCAM_CORE_INLINE Homography Homography::with_in_front(const Vec2& source) const {
  const double w = denominator(source);
  if (w == 0.0) throw std::invalid_argument("Homography::with_in_front: the point lies on the horizon");
  return w > 0.0 ? *this : Homography(Mat3(-matrix_));
}

PROCAM_CORE_INLINE Homography operator*(const Homography& target_from_middle,
                                        const Homography& middle_from_source) {
  return Homography(Mat3(target_from_middle.matrix() * middle_from_source.matrix()));
}

namespace detail {

PROCAM_CORE_INLINE std::optional<Mat3> exact_from_four(const std::array<Vec2, 4>& source,
                                                       const std::array<Vec2, 4>& destination,
                                                       double tolerance) {
  using Pair = Eigen::Array<double, 2, 1>;
  const auto& s = source;
  const auto& d = destination;
  const Pair x3(s[3].x(), d[3].x()), y3(s[3].y(), d[3].y());
  const Pair x0 = Pair(s[0].x(), d[0].x()) - x3, y0 = Pair(s[0].y(), d[0].y()) - y3;
  const Pair x1 = Pair(s[1].x(), d[1].x()) - x3, y1 = Pair(s[1].y(), d[1].y()) - y3;
  const Pair x2 = Pair(s[2].x(), d[2].x()) - x3, y2 = Pair(s[2].y(), d[2].y()) - y3;
  const Pair area0 = x1 * y2 - x2 * y1, area1 = x2 * y0 - x0 * y2, area2 = x0 * y1 - x1 * y0;
  const Pair area3 = area0 + area1 + area2;

  const Pair squared_size = (x0 * x0 + y0 * y0).max(x1 * x1 + y1 * y1).max(x2 * x2 + y2 * y2);
  const Pair smallest = area0.abs().min(area1.abs()).min(area2.abs().min(area3.abs()));
  const Pair margin = smallest - tolerance * squared_size;
  const double p0 = area0.prod(), p1 = area1.prod(), p2 = area2.prod(), p3 = area3.prod();
  const bool one_side = std::min(std::min(p0, p1), std::min(p2, p3)) > 0.0 ||
                        std::max(std::max(p0, p1), std::max(p2, p3)) < 0.0;
  if (!(margin[0] > 0.0 && margin[1] > 0.0 && one_side)) return std::nullopt;  // NaN and infinity included

  const double l01 = area0[0] * area1[0];
  const double k = 1.0 / (l01 * area2[0] * area3[1]);
  const Pair g0 = (area0[1] * area1[0] * area2[0] * k) * Pair(y1[0] - y2[0], x2[0] - x1[0]);
  const Pair g1 = (area1[1] * area0[0] * area2[0] * k) * Pair(y2[0] - y0[0], x0[0] - x2[0]);
  const Pair g2 = (area2[1] * l01 * k) * Pair(y0[0] - y1[0], x1[0] - x0[0]);
  const Pair u = x0[1] * g0 + x1[1] * g1 + x2[1] * g2;
  const Pair v = y0[1] * g0 + y1[1] * g1 + y2[1] * g2;
  const Pair w = g0 + g1 + g2;

  const Pair from(x3[0], y3[0]), to(x3[1], y3[1]);  // pair 3
  const Pair row0 = u + to[0] * w, row1 = v + to[1] * w;
  const double h22 = 1.0 - (w * from).sum();
  const Pair last = h22 * to - Pair((u * from).sum(), (v * from).sum());
  Mat3 matrix;
  Eigen::Map<Eigen::Array<double, 9, 1>> entries(matrix.data());  // column by column, stored in pairs
  entries.segment<2>(0) = Pair(row0[0], row1[0]);
  entries.segment<2>(2) = Pair(w[0], row0[1]);
  entries.segment<2>(4) = Pair(row1[1], w[1]);
  entries.segment<2>(6) = last;
  entries[8] = h22;
  return matrix;
}

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

}  // namespace detail

PROCAM_CORE_INLINE Homography homography_from_four_points(const std::array<Vec2, 4>& source,
                                                          const std::array<Vec2, 4>& destination) {
  const std::optional<Mat3> matrix = detail::exact_from_four(source, destination, kCollinearTolerance);
  if (!matrix) detail::refuse_four(source, destination, {0, 1, 2, 3}, kCollinearTolerance);
  return Homography::trusted(*matrix);
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
