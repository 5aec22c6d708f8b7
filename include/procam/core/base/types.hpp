#pragma once
/// Scalars, vectors and sizes that every other noun is made of.
///
/// Pixels: (0,0) is the centre of the top-left pixel; an image spans [-0.5, W-0.5] x [-0.5, H-0.5].
/// Units: metres, radians, seconds, pixels; anything else carries a suffix. See docs/conventions.md.
#include <Eigen/Core>
#include <cmath>
#include <vector>

namespace procam {

template <typename T>
using Vec2T = Eigen::Matrix<T, 2, 1>;
template <typename T>
using Vec3T = Eigen::Matrix<T, 3, 1>;
template <typename T>
using Mat3T = Eigen::Matrix<T, 3, 3>;

using Vec2 = Vec2T<double>;
using Vec3 = Vec3T<double>;
using Vec4 = Eigen::Matrix<double, 4, 1>;
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat2 = Eigen::Matrix<double, 2, 2>;
using Mat3 = Mat3T<double>;
using Mat4 = Eigen::Matrix<double, 4, 4>;
using Mat6 = Eigen::Matrix<double, 6, 6>;
using Mat23 = Eigen::Matrix<double, 2, 3>;
using Mat34 = Eigen::Matrix<double, 3, 4>;
using MatX = Eigen::MatrixXd;
using VecX = Eigen::VectorXd;

inline constexpr double kPi = 3.141592653589793238462643383279502884;
inline constexpr double kDegree = kPi / 180;  ///< in radians

/// Fixed-size vectors of 16-byte multiples need Eigen's allocator only before C++17; std::vector is right
/// here.
using Points2 = std::vector<Vec2>;
using Points3 = std::vector<Vec3>;

/// The number behind a scalar: itself for a double, the value part for a Ceres Jet (recognised by its member
/// `a`). For decisions (sign, convergence) that must not carry derivatives.
inline double value_of(double x) {
  return x;
}
template <typename Jet>
auto value_of(const Jet& x) -> decltype(static_cast<double>(x.a)) {
  return static_cast<double>(x.a);
}

/// Are the values behind both scalars finite? (NaN and infinity never leave a lens model.)
template <typename T>
bool is_finite(const Vec2T<T>& v) {
  return std::isfinite(value_of(v.x())) && std::isfinite(value_of(v.y()));
}

/// Width and height in pixels.
struct ImageSize {
  int width = 0;
  int height = 0;

  bool operator==(const ImageSize& other) const { return width == other.width && height == other.height; }
  bool operator!=(const ImageSize& other) const { return !(*this == other); }

  /// Is the pixel position inside the picture's area, [-0.5, W-0.5) x [-0.5, H-0.5)?
  bool contains(const Vec2& pixel) const {
    return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < width - 0.5 && pixel.y() < height - 0.5;
  }
};

}  // namespace procam
