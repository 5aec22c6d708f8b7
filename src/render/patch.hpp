#pragma once
/// A vector field over a small rectangle of pixels as a biquadratic polynomial: f(s, t) = sum c[i][j] s^i
/// t^j, s and t from -1 to 1 across the rectangle. Exact for the linear maps of a pinhole; for lenses the
/// maker checks it.
#include <Eigen/Geometry>
#include <array>

#include "procam/core/types.hpp"

namespace procam::render {

/// Whole pixels [x0, x1) x [y0, y1): the area [x0 - 1/2, x1 - 1/2] x [y0 - 1/2, y1 - 1/2].
struct PixelRect {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  int width() const { return x1 - x0; }
  int height() const { return y1 - y0; }
  double s(double x) const { return (2 * x - (x0 + x1 - 1)) / width(); }
  double t(double y) const { return (2 * y - (y0 + y1 - 1)) / height(); }
  Vec2 pixel(double s, double t) const {
    return Vec2(0.5 * (x0 + x1 - 1 + s * width()), 0.5 * (y0 + y1 - 1 + t * height()));
  }
};

/// A quadratic in one variable, c[0] + c[1] s + c[2] s^2.
using Quadratic3 = std::array<Vec3, 3>;

inline Quadratic3 quadratic_through(const Vec3& at_minus_1, const Vec3& at_0, const Vec3& at_1) {
  return {at_0, Vec3(0.5 * (at_1 - at_minus_1)), Vec3(0.5 * (at_1 + at_minus_1) - at_0)};
}

struct Patch {
  std::array<Quadratic3, 3> c;  ///< c[j] multiplies t^j

  /// Through the values at s, t = -1, 0, 1, row by row.
  static Patch through(const std::array<Vec3, 9>& nodes) {
    std::array<Quadratic3, 3> rows;
    for (std::size_t j = 0; j < 3; ++j)
      rows[j] = quadratic_through(nodes[3 * j], nodes[3 * j + 1], nodes[3 * j + 2]);
    Patch patch;
    for (std::size_t i = 0; i < 3; ++i) {
      const Quadratic3 down = quadratic_through(rows[0][i], rows[1][i], rows[2][i]);
      for (std::size_t j = 0; j < 3; ++j) patch.c[j][i] = down[j];
    }
    return patch;
  }

  /// The field of pixel positions themselves, (x, y, 1).
  static Patch of_pixels(const PixelRect& rect) {
    std::array<Vec3, 9> nodes;
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) nodes[std::size_t(3 * j + i)] = rect.pixel(i - 1, j - 1).homogeneous();
    return through(nodes);
  }

  /// The row at t, as a quadratic in s; and its derivative in t.
  Quadratic3 row(double t) const {
    Quadratic3 r;
    for (std::size_t i = 0; i < 3; ++i) r[i] = c[0][i] + t * (c[1][i] + t * c[2][i]);
    return r;
  }
  Quadratic3 row_slope(double t) const {
    Quadratic3 r;
    for (std::size_t i = 0; i < 3; ++i) r[i] = c[1][i] + 2 * t * c[2][i];
    return r;
  }
  Vec3 at(double s, double t) const {
    const Quadratic3 r = row(t);
    return r[0] + s * (r[1] + s * r[2]);
  }

  friend Patch operator*(const Mat3& m, const Patch& patch) {
    Patch result;
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t i = 0; i < 3; ++i) result.c[j][i] = m * patch.c[j][i];
    return result;
  }

  /// The smallest and largest Bernstein coefficient of a component combination: the field's values lie
  /// between them over the whole rectangle (the convex hull property).
  struct Bounds {
    double low, high;
  };
  Bounds bounds(const Eigen::RowVector3d& combination) const {
    // In one variable on [-1, 1]: b = (c0 - c1 + c2, c0 - c2, c0 + c1 + c2).
    Mat3 b;  // rows: j, columns: i
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) b(j, i) = combination * c[std::size_t(j)][std::size_t(i)];
    Mat3 bernstein_from_power;
    bernstein_from_power << 1, -1, 1, 1, 0, -1, 1, 1, 1;
    const Mat3 coefficients = bernstein_from_power * b * bernstein_from_power.transpose();
    return {coefficients.minCoeff(), coefficients.maxCoeff()};
  }
};

}  // namespace procam::render
