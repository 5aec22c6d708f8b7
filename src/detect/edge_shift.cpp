#include "edge_shift.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "board_map.hpp"
#include "procam/core/base/cholesky.hpp"

namespace procam::detect {
namespace {

constexpr std::size_t kFewestCorners = 12;
/// Pixels by which edges of a sharp or blurred image are displaced, one standard deviation; the second and
/// third of each axis are what the displacement changes by over the board.
constexpr double kShiftSigmaPx = 0.5, kShiftChangePx = 0.25;
constexpr int kTerms = 6;
using Terms = Eigen::Matrix<double, kTerms, 1>;
using TermsMatrix = Eigen::Matrix<double, kTerms, kTerms>;

class ShiftFit {
 public:
  ShiftFit(const std::vector<FoundCorner>& corners, ImageSize size) : corners_(corners), size_(size) {
    Eigen::AlignedBox2d box;
    for (const FoundCorner& corner : corners) {
      box.extend(corner.in_board);
      pixels_.push_back(corner.pixel);
      // Each weighs by its sigma, but none by more than ten times the others: the map is no exact one.
      weights_.push_back(1 / (corner.covariance.trace() / 2 + 0.01));
    }
    middle_ = box.center();
    half_ = 0.5 * box.sizes().maxCoeff();
  }

  /// The board's length of a pixel, roughly.
  std::optional<double> pixel_in_board() const {
    const auto map = BoardMap::fit(in_board(Terms::Zero()), pixels_, size_, weights_);
    if (!map) return std::nullopt;
    const auto a = map->at(middle_ - Vec2(0.1 * half_, 0)), b = map->at(middle_ + Vec2(0.1 * half_, 0));
    if (!a || !b || !((*b - *a).norm() > 0)) return std::nullopt;
    return 0.2 * half_ / (*b - *a).norm();
  }

  /// Rows of the terms: displacement of a corner, board lengths.
  Eigen::Matrix<double, 2, kTerms> displacement(const FoundCorner& corner) const {
    const Vec2 at = (corner.in_board - middle_) / half_;
    Eigen::Matrix<double, 2, kTerms> by = Eigen::Matrix<double, 2, kTerms>::Zero();
    by.block<1, 3>(0, 0) = -corner.outwards.x() * Eigen::RowVector3d(1, at.x(), at.y());
    by.block<1, 3>(1, 3) = -corner.outwards.y() * Eigen::RowVector3d(1, at.x(), at.y());
    return by;
  }

  Points2 in_board(const Terms& terms) const {
    Points2 points;
    for (const FoundCorner& corner : corners_)
      points.push_back(corner.in_board + displacement(corner) * terms);
    return points;
  }

  std::optional<BoardMap> map(const Terms& terms) const {
    return BoardMap::fit(in_board(terms), pixels_, size_, weights_);
  }

  /// Weighted residuals of the best map for these terms.
  std::optional<VecX> residuals(const Terms& terms) const {
    const Points2 points = in_board(terms);
    const auto map = BoardMap::fit(points, pixels_, size_, weights_);
    if (!map) return std::nullopt;
    VecX all(2 * Eigen::Index(points.size()));
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto pixel = map->at(points[i]);
      if (!pixel) return std::nullopt;
      all.segment<2>(2 * Eigen::Index(i)) = std::sqrt(weights_[i]) * (*pixel - pixels_[i]);
    }
    return all;
  }

 private:
  const std::vector<FoundCorner>& corners_;
  ImageSize size_;
  Points2 pixels_;
  std::vector<double> weights_;
  Vec2 middle_;
  double half_ = 1;
};

struct Shift {
  Terms terms = Terms::Zero();
  TermsMatrix covariance;
};

/// Gauss-Newton, the map eliminated at every step.
std::optional<Shift> fit_shift(const ShiftFit& fit, double pixel) {
  Terms sigma;
  sigma << kShiftSigmaPx, kShiftChangePx, kShiftChangePx, kShiftSigmaPx, kShiftChangePx, kShiftChangePx;
  sigma *= pixel;
  Shift shift;
  for (int iteration = 0; iteration < 2; ++iteration) {
    const auto here = fit.residuals(shift.terms);
    if (!here) return std::nullopt;
    MatX by_terms(here->size(), kTerms);
    for (int k = 0; k < kTerms; ++k) {
      const double step = 0.1 * sigma[k];
      const auto there = fit.residuals(shift.terms + step * Terms::Unit(k));
      if (!there) return std::nullopt;
      by_terms.col(k) = (*there - *here) / step;
    }
    const double variance = here->squaredNorm() / double(here->size() - kTerms);
    TermsMatrix information = by_terms.transpose() * by_terms / std::max(variance, 1e-6);
    information.diagonal() += sigma.cwiseAbs2().cwiseInverse();
    const Terms pull = Terms(by_terms.transpose() * *here) / std::max(variance, 1e-6) +
                       shift.terms.cwiseQuotient(sigma.cwiseAbs2());
    const Cholesky factors(information);
    shift.terms -= factors.solve(pull);
    shift.covariance = factors.inverse();
  }
  if (!shift.terms.allFinite() || !shift.covariance.allFinite()) return std::nullopt;
  return shift;
}

struct Moved {
  Vec2 by;              ///< pixels, of the displacement
  Mat2 pixel_by_board;  ///< derivative of the map
};

std::optional<Moved> moved_by(const BoardMap& map, const Vec2& in_board, const Vec2& displacement,
                              double pixel) {
  const auto here = map.at(in_board), there = map.at(in_board + displacement);
  const auto x = map.at(in_board + Vec2(pixel, 0)), y = map.at(in_board + Vec2(0, pixel));
  if (!here || !there || !x || !y) return std::nullopt;
  Moved moved{*there - *here, {}};
  moved.pixel_by_board << (*x - *here) / pixel, (*y - *here) / pixel;
  if (!(std::abs(moved.pixel_by_board.determinant()) > 0)) return std::nullopt;
  return moved;
}

/// Variance by axis of single markers' displacements about the common one, beyond the noise of their corners
/// (two of which share each edge). An overexposed image has it: its edges move by as much as they are too
/// bright.
Vec2 excess_variance(const std::vector<FoundCorner>& corners, const std::vector<Moved>& moved,
                     const BoardMap& map) {
  Vec2 excess = Vec2::Zero();
  for (std::size_t first = 0; first + 4 <= corners.size(); first += 4) {
    Vec2 mean = Vec2::Zero(), variance = Vec2::Zero();
    for (std::size_t i = first; i < first + 4; ++i) {
      const Mat2 board_by_pixel = moved[i].pixel_by_board.inverse();
      const Vec2 left = corners[i].pixel - moved[i].by - *map.at(corners[i].in_board);
      mean += 0.25 * corners[i].outwards.cwiseProduct(board_by_pixel * left);
      variance +=
          2 * 0.0625 * Vec2((board_by_pixel * corners[i].covariance * board_by_pixel.transpose()).diagonal());
    }
    excess += mean.cwiseAbs2() - variance;
  }
  return (excess / double(corners.size() / 4)).cwiseMax(0);
}

}  // namespace

void remove_edge_shift(std::vector<FoundCorner>& corners, ImageSize size) {
  if (corners.size() < kFewestCorners) return;
  const ShiftFit fit(corners, size);
  const auto pixel = fit.pixel_in_board();
  const auto shift = pixel ? fit_shift(fit, *pixel) : std::nullopt;
  const auto map = shift ? fit.map(shift->terms) : std::nullopt;
  if (!map) return;
  std::vector<Moved> moved;
  for (const FoundCorner& corner : corners) {
    const auto one = moved_by(*map, corner.in_board, fit.displacement(corner) * shift->terms, *pixel);
    if (!one) return;
    moved.push_back(*one);
  }
  const Vec2 excess = excess_variance(corners, moved, *map);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Mat2& by_board = moved[i].pixel_by_board;
    const Eigen::Matrix<double, 2, kTerms> by_terms = by_board * fit.displacement(corners[i]);
    corners[i].pixel -= moved[i].by;
    corners[i].covariance += by_terms * shift->covariance * by_terms.transpose() +
                             by_board * excess.asDiagonal() * by_board.transpose();
  }
}

}  // namespace procam::detect
