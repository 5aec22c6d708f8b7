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
#include <array>
#include <cmath>
#include <optional>

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
  Homography() : matrix_(Mat3::Identity()) {}

  /// The map with this matrix, kept as it is. Singular or non-finite: std::invalid_argument.
  PROCAM_EXPORT explicit Homography(const Mat3& matrix);

  /// For solvers that know their matrix to be regular: nothing is checked.
  static Homography trusted(const Mat3& matrix) {
    Homography h{Unset()};
    h.matrix_ = matrix;
    return h;
  }

  /// Positive denominators in front; any positive scale (a fit of many points: unit Frobenius norm).
  const Mat3& matrix() const { return matrix_; }

  /// The same map with unit Frobenius norm: the form to compare and to store.
  PROCAM_EXPORT Homography normalised() const;

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
  PROCAM_EXPORT Mat2 jacobian(const Vec2& source) const;

  /// d(mapped point) / d(h), h the nine entries row by row, for a point in front.
  PROCAM_EXPORT Mat29 jacobian_of_entries(const Vec2& source) const;

  /// Does the map turn a clockwise figure (in front of the horizon) into a counter-clockwise one? Legal: rear
  /// projection and y-up surface coordinates do it.
  PROCAM_EXPORT bool mirrors() const;

  /// source_from_destination.
  PROCAM_EXPORT Homography inverse() const;

  /// The same projective map, with its front on this source point's side of the horizon (for matrices of
  /// unknown sign, such as those read from files). A point on the horizon: std::invalid_argument.
  PROCAM_EXPORT Homography with_in_front(const Vec2& source) const;

 private:
  struct Unset {};
  explicit Homography(Unset) {}

  Mat3 matrix_;
};

/// target_from_source = target_from_middle * middle_from_source.
PROCAM_EXPORT Homography operator*(const Homography& target_from_middle,
                                   const Homography& middle_from_source);

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
PROCAM_EXPORT std::optional<Mat3> exact_from_four(const std::array<Vec2, 4>& source,
                                                  const std::array<Vec2, 4>& destination, double tolerance);

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
PROCAM_EXPORT Homography homography_from_four_points(const std::array<Vec2, 4>& source,
                                                     const std::array<Vec2, 4>& destination);

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/geometry/detail/homography_body.hpp"
#endif
