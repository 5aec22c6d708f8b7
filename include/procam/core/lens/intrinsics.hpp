#pragma once
/// The five-parameter intrinsic matrix
///
///       | fx skew cx |
///   K = |  0  fy  cy |      pixel = K * (x, y, 1)
///       |  0   0   1 |
///
/// All in pixels, pixel centres at integers. The principal point may lie anywhere: a projector with lens
/// shift has its cy below the image, and nothing may pull it to the centre.
#include <array>

#include "procam/core/base/types.hpp"

namespace procam {

template <typename T>
struct IntrinsicsT {
  T fx = T(1), fy = T(1), cx = T(0), cy = T(0), skew = T(0);

  Mat3T<T> matrix() const {
    Mat3T<T> k;
    k << fx, skew, cx, T(0), fy, cy, T(0), T(0), T(1);
    return k;
  }
  /// From a K of the form above: upper triangular, K(2,2) = 1.
  static IntrinsicsT from_matrix(const Mat3T<T>& k) { return {k(0, 0), k(1, 1), k(0, 2), k(1, 2), k(0, 1)}; }

  /// Parameter order of every file, cost functor and covariance: fx, fy, cx, cy, skew.
  static constexpr int kNumParameters = 5;
  static IntrinsicsT from_array(const T* p) { return {p[0], p[1], p[2], p[3], p[4]}; }
  std::array<T, 5> to_array() const { return {fx, fy, cx, cy, skew}; }

  /// From the (distorted) normalised image plane z = 1 to pixels.
  Vec2T<T> pixel_from_normalized(const Vec2T<T>& n) const {
    return Vec2T<T>(fx * n.x() + skew * n.y() + cx, fy * n.y() + cy);
  }
  Vec2T<T> normalized_from_pixel(const Vec2T<T>& pixel) const {
    const T y = (pixel.y() - cy) / fy;
    return Vec2T<T>((pixel.x() - cx - skew * y) / fx, y);
  }
};

using Intrinsics = IntrinsicsT<double>;

constexpr std::array<const char*, 5> kIntrinsicsNames{"fx", "fy", "cx", "cy", "skew"};

}  // namespace procam
