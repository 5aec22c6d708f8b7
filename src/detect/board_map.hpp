#pragma once
/// Where the points of a flat board appear: a homography seen through a simple lens about the picture's
/// middle c. From a pixel p, with d = p - c in half diagonals,
///
///   H b = c + d / (1 + lambda |d|^2) + t(d),   t = (2 p1 x y + p2 (r^2 + 2 x^2), p1 (r^2 + 2 y^2) + 2 p2 x
///   y)
///
/// (the division model, Fitzgibbon 2001, and Brown's decentring, which also stands for an optical centre
/// beside the picture's). A detector's substitute for the lens: it predicts positions, and how edges bend.
#include <optional>
#include <vector>

#include "procam/core/base/types.hpp"
#include "procam/core/geometry/homography.hpp"

namespace procam::detect {

class BoardMap {
 public:
  /// Weighted least squares; nullopt for points that fix no map. Few or noisy points leave the lens at zero.
  static std::optional<BoardMap> fit(const Points2& in_board, const Points2& pixels, ImageSize size,
                                     const std::vector<double>& weights = {});

  /// The pixel of a board point; nullopt beyond the horizon.
  std::optional<Vec2> at(const Vec2& in_board) const;

 private:
  Homography undistorted_from_board_;
  Vec2 centre_ = Vec2::Zero();
  double half_diagonal_ = 1;
  Vec3 lens_ = Vec3::Zero();  ///< lambda, p1, p2
};

}  // namespace procam::detect
