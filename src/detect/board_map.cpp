#include "board_map.hpp"

#include <cmath>

#include "procam/core/base/cholesky.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/geometry/homography_fit.hpp"

namespace procam::detect {
namespace {

/// Sigma of a marker's corner as found, pixels, and of the three terms over lenses: what the data must beat
/// to move them.
constexpr double kPixelSigma = 0.5;
const Vec3 kLensSigma(0.15, 0.01, 0.01);

Vec2 decentring(const Vec3& lens, const Vec2& d) {
  const double r2 = d.squaredNorm(), xy = d.x() * d.y();
  return Vec2(2 * lens[1] * xy + lens[2] * (r2 + 2 * d.x() * d.x()),
              lens[1] * (r2 + 2 * d.y() * d.y()) + 2 * lens[2] * xy);
}

Vec2 undistort(const Vec3& lens, const Vec2& d) {
  return d / (1 + lens[0] * d.squaredNorm()) + decentring(lens, d);
}

std::optional<Vec2> distort(const Vec3& lens, const Vec2& u) {
  Vec2 d = u;
  for (int i = 0; i < 5; ++i) {  // decentring is small: each round gains two digits
    const Vec2 radial = u - decentring(lens, d);
    const double root = 1 - 4 * lens[0] * radial.squaredNorm();
    if (!(root > 0)) return std::nullopt;
    // r_d = (1 - sqrt(1 - 4 lambda r_u^2)) / (2 lambda r_u), written without the division by zero.
    d = radial * (2 / (1 + std::sqrt(root)));
    if (!(d.squaredNorm() < 100)) return std::nullopt;
  }
  return d;
}

}  // namespace

std::optional<Vec2> BoardMap::at(const Vec2& in_board) const {
  const auto undistorted = undistorted_from_board_.apply(in_board);
  if (!undistorted) return std::nullopt;
  const auto d = distort(lens_, (*undistorted - centre_) / half_diagonal_);
  if (!d) return std::nullopt;
  return Vec2(centre_ + half_diagonal_ * *d);
}

std::optional<BoardMap> BoardMap::fit(const Points2& in_board, const Points2& pixels, ImageSize size,
                                      const std::vector<double>& weights) {
  BoardMap map;
  map.centre_ = 0.5 * Vec2(size.width - 1, size.height - 1);
  map.half_diagonal_ = 0.5 * Vec2(size.width, size.height).norm();
  HomographyOptions options;
  options.weights = weights;
  // What the best homography leaves for this lens, in sigmas: residuals, then the lens itself.
  const auto remainder = [&](const Vec3& lens) {
    Points2 undistorted;
    for (const Vec2& p : pixels)
      undistorted.push_back(map.centre_ +
                            map.half_diagonal_ * undistort(lens, (p - map.centre_) / map.half_diagonal_));
    const HomographyFit fit = fit_homography(in_board, undistorted, options);
    map.undistorted_from_board_ = fit.destination_from_source;
    VecX left(2 * Eigen::Index(pixels.size()) + 3);
    for (std::size_t i = 0; i < pixels.size(); ++i)
      left.segment<2>(2 * Eigen::Index(i)) =
          std::sqrt(weights.empty() ? 1 : weights[i]) / kPixelSigma * fit.residuals[i];
    left.tail<3>() = lens.cwiseQuotient(kLensSigma);
    return left;
  };
  try {
    // Gauss-Newton on the lens, the homography eliminated at every step. Four points leave nothing to fit.
    for (int iteration = 0; iteration < 3 && pixels.size() > 4; ++iteration) {
      const VecX here = remainder(map.lens_);
      MatX by_lens(here.size(), 3);
      for (int k = 0; k < 3; ++k) {
        const double step = 0.05 * kLensSigma[k];
        by_lens.col(k) = (remainder(map.lens_ + step * Vec3::Unit(k)) - here) / step;
      }
      const Vec3 change =
          Cholesky(Mat3(by_lens.transpose() * by_lens)).solve(Vec3(by_lens.transpose() * here));
      map.lens_ = (map.lens_ - change).cwiseMin(4 * kLensSigma).cwiseMax(-4 * kLensSigma);
    }
    remainder(map.lens_);
  } catch (const Error&) {
    return std::nullopt;
  }
  return map;
}

}  // namespace procam::detect
