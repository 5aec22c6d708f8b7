#pragma once
/// The homography: the projective map between two planes, and the exact one through four point pairs.
///
///   w * [u, v, 1]^T = H * [x, y, 1]^T,     (x, y) in the source plane, (u, v) in the destination plane
///
/// A positive factor changes nothing; the sign does: a point with denominator w > 0 is in front of the
/// horizon, one with w <= 0 has no image. Every fit orients H so that its own points are in front.
/// Composition and inversion keep this meaning: p in front for the first map and its image in front for the
/// second is the same as p in front for the product (Stolfi, Oriented Projective Geometry, 1991). h33 = 1 is
/// not imposed: it breaks down where the origin lies on the horizon, and turns the sign where the origin lies
/// beyond it.
///
/// Fitting many points: homography_fit.hpp. Outliers: homography_robust.hpp. Pixels: see docs/conventions.md.
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "procam/core/base/error.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/base/types.hpp"

namespace procam {

using Mat9 = Eigen::Matrix<double, 9, 9>;
using Mat29 = Eigen::Matrix<double, 2, 9>;

/// Four points of which three lie within this fraction of the quadrilateral's size of one line (twice the
/// triangle's area over the squared longest distance to the fourth point) do not carry a homography. A
/// thousandth of a pixel over a thousand pixels: ten times the rounding of coordinates that were once stored
/// as float.
inline constexpr double kCollinearTolerance = 1e-6;

/// A map named destination_from_source, e.g. projector_from_wall * wall_from_picture.
class Homography {
 public:
  Homography() : Homography(Mat3::Identity()) {}

  /// The map with this matrix, kept as it is. Singular or non-finite: std::invalid_argument.
  explicit Homography(const Mat3& matrix) : matrix_(matrix) {
    const double determinant = matrix.determinant();
    if (!std::isfinite(determinant) || determinant == 0.0)
      throw std::invalid_argument("Homography: the matrix is singular or not finite");
  }

  /// For solvers that know their matrix to be regular: nothing is checked.
  static Homography trusted(const Mat3& matrix) {
    Homography h{Unset()};
    h.matrix_ = matrix;
    return h;
  }

  /// Positive denominators in front; any positive scale (a fit of many points: unit Frobenius norm).
  const Mat3& matrix() const { return matrix_; }

  /// The same map with unit Frobenius norm: the form to compare and to store.
  Homography normalised() const { return Homography(Mat3(matrix_ / matrix_.norm())); }

  /// The third homogeneous coordinate of the mapped point: positive in front of the horizon.
  double denominator(const Vec2& source) const {
    return matrix_(2, 0) * source.x() + matrix_(2, 1) * source.y() + matrix_(2, 2);
  }

  /// The mapped point; nullopt on the horizon (to within rounding) or beyond it.
  std::optional<Vec2> apply(const Vec2& source) const {
    const double magnitude =
        std::abs(matrix_(2, 0) * source.x()) + std::abs(matrix_(2, 1) * source.y()) + std::abs(matrix_(2, 2));
    if (!(denominator(source) > 1e-13 * magnitude)) return std::nullopt;
    return apply_unchecked(source);
  }

  /// The mapped point for inner loops whose points are known to be in front.
  Vec2 apply_unchecked(const Vec2& source) const {
    const double q = 1.0 / denominator(source);
    return {(matrix_(0, 0) * source.x() + matrix_(0, 1) * source.y() + matrix_(0, 2)) * q,
            (matrix_(1, 0) * source.x() + matrix_(1, 1) * source.y() + matrix_(1, 2)) * q};
  }

  /// d(mapped point) / d(source point), for a point in front.
  Mat2 jacobian(const Vec2& source) const {
    return (matrix_.topLeftCorner<2, 2>() - apply_unchecked(source) * matrix_.bottomLeftCorner<1, 2>()) /
           denominator(source);
  }

  /// d(mapped point) / d(h), h the nine entries row by row, for a point in front.
  Mat29 jacobian_of_entries(const Vec2& source) const {
    const Eigen::RowVector3d s = Vec3(source.x(), source.y(), 1.0).transpose() / denominator(source);
    const Vec2 mapped = apply_unchecked(source);
    Mat29 jacobian;
    jacobian << s, Eigen::RowVector3d::Zero(), -mapped.x() * s, Eigen::RowVector3d::Zero(), s,
        -mapped.y() * s;
    return jacobian;
  }

  /// Does the map turn a clockwise figure (in front of the horizon) into a counter-clockwise one? Legal: rear
  /// projection and y-up surface coordinates do it.
  bool mirrors() const { return matrix_.determinant() < 0.0; }

  /// source_from_destination.
  Homography inverse() const { return Homography(Mat3(matrix_.inverse())); }

  /// The same projective map, with its front on this source point's side of the horizon (for matrices of
  /// unknown sign, such as those read from files). A point on the horizon: std::invalid_argument.
  Homography with_in_front(const Vec2& source) const {
    const double w = denominator(source);
    if (w == 0.0) throw std::invalid_argument("Homography::with_in_front: the point lies on the horizon");
    return w > 0.0 ? *this : Homography(Mat3(-matrix_));
  }

 private:
  struct Unset {};
  explicit Homography(Unset) {}

  Mat3 matrix_;
};

/// target_from_source = target_from_middle * middle_from_source.
inline Homography operator*(const Homography& target_from_middle, const Homography& middle_from_source) {
  return Homography(Mat3(target_from_middle.matrix() * middle_from_source.matrix()));
}

namespace detail {

/// The matrix through four pairs, with denominator 1 at the last; nullopt when a set is not general or
/// crosses the horizon.
///
/// With homogeneous s_i and triangle areas l_i: l_3 s_3 = l_0 s_0 + l_1 s_1 + l_2 s_2, likewise m_i for d_i,
/// so H = sum_i (m_i / l_i) d_i (s_j x s_k)^T, and the denominator at every s_i (the fourth included) is m_i
/// / l_i up to one common factor: the horizon leaves all four on one side exactly when the products l_i m_i
/// share one sign. (Projective frames: Hartley & Zisserman 2004, 2.2.) Written from point 3, where the last
/// column's top vanishes. The areas run in two lanes (source, destination), the rest in the lanes (column 0,
/// column 1) of H.
inline std::optional<Mat3> exact_from_four(const std::array<Vec2, 4>& source,
                                           const std::array<Vec2, 4>& destination, double tolerance) {
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

/// Says why exact_from_four had no answer. `index` gives the caller's number of each of the four pairs.
[[noreturn]] PROCAM_EXPORT void refuse_four(const std::array<Vec2, 4>& source,
                                            const std::array<Vec2, 4>& destination,
                                            const std::array<int, 4>& index, double tolerance);

}  // namespace detail

/// destination_from_source exactly through four pairs, in closed form; all four are in front of the horizon.
///
/// Errors: kInput for a non-finite coordinate; kDegenerate for repeated points, three collinear of the four
/// (in either plane, kCollinearTolerance), points across the horizon. Messages name the points by their
/// position 0..3.
inline Homography homography_from_four_points(const std::array<Vec2, 4>& source,
                                              const std::array<Vec2, 4>& destination) {
  const std::optional<Mat3> matrix = detail::exact_from_four(source, destination, kCollinearTolerance);
  if (!matrix) detail::refuse_four(source, destination, {0, 1, 2, 3}, kCollinearTolerance);
  return Homography::trusted(*matrix);
}

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/geometry/detail/homography_body.hpp"
#endif
