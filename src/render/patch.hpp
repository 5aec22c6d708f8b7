#pragma once
/// A vector field over a small rectangle of pixels as a biquadratic polynomial: f(s, t) = sum c[i][j] s^i
/// t^j, s and t from -1 to 1 across the rectangle. Exact for the linear maps of a pinhole; for lenses the
/// maker checks it.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "procam/core/base/types.hpp"

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

  /// The Bernstein coefficients: the field's values over the whole rectangle lie in their convex hull.
  std::array<Vec3, 9> bernstein() const {
    // In one variable on [-1, 1]: (c0 - c1 + c2, c0 - c2, c0 + c1 + c2).
    const auto from_power = [](const Vec3& c0, const Vec3& c1, const Vec3& c2) {
      const Vec3 even = c0 + c2;
      return Quadratic3{even - c1, c0 - c2, even + c1};
    };
    std::array<Quadratic3, 3> rows;
    for (std::size_t j = 0; j < 3; ++j) rows[j] = from_power(c[j][0], c[j][1], c[j][2]);
    std::array<Vec3, 9> coefficients;
    for (std::size_t i = 0; i < 3; ++i) {
      const Quadratic3 down = from_power(rows[0][i], rows[1][i], rows[2][i]);
      for (std::size_t j = 0; j < 3; ++j) coefficients[3 * j + i] = down[j];
    }
    return coefficients;
  }
};

/// Between which values a combination of the components lies, of a field with these Bernstein coefficients.
struct Bounds {
  double low, high;
};
inline Bounds bounds(const Eigen::RowVector3d& combination, const std::array<Vec3, 9>& bernstein) {
  Bounds result{combination * bernstein[0], combination * bernstein[0]};
  for (std::size_t n = 1; n < bernstein.size(); ++n) {
    const double value = combination * bernstein[n];
    result = {std::min(result.low, value), std::max(result.high, value)};
  }
  return result;
}

}  // namespace procam::render
