#pragma once
/// A board's drawing made ready for many questions: is it dark here, and how much of this box is?
///
/// The sheet is cut into cells, each with the shapes that reach into it, so that an answer costs a few shapes
/// whatever the board holds. Off the sheet nothing is dark.
#include <algorithm>
#include <cmath>
#include <vector>

#include "procam/core/board/board_artwork.hpp"

namespace procam {

/// Area that a box and a disc about the origin share: the height between the rims, integrated along x piece
/// by piece, with the cuts where the rim crosses the box's sides.
inline double area_of_disc_in_box(double radius, const Vec2& low, const Vec2& high) {
  const double left = std::max(low.x(), -radius), right = std::min(high.x(), radius);
  if (!(left < right) || low.y() >= radius || high.y() <= -radius) return 0;
  std::vector<double> cuts{left, right};
  for (const double y : {low.y(), high.y()})
    if (std::abs(y) < radius)
      for (const double x : {-std::sqrt(radius * radius - y * y), std::sqrt(radius * radius - y * y)})
        if (x > left && x < right) cuts.push_back(x);
  std::sort(cuts.begin(), cuts.end());
  const auto rim = [&](double x) { return std::sqrt(std::max(0.0, radius * radius - x * x)); };
  // Integral of the upper rim from 0.
  const auto under_rim = [&](double x) {
    return 0.5 * (x * rim(x) + radius * radius * std::asin(std::clamp(x / radius, -1.0, 1.0)));
  };
  double area = 0;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    const double a = cuts[i], b = cuts[i + 1], middle = rim(0.5 * (a + b));
    if (std::min(high.y(), middle) <= std::max(low.y(), -middle)) continue;
    const double arc = under_rim(b) - under_rim(a);
    area += (high.y() < middle ? high.y() * (b - a) : arc) - (low.y() > -middle ? low.y() * (b - a) : -arc);
  }
  return area;
}

class ArtworkIndex {
 public:
  explicit ArtworkIndex(const BoardArtwork& artwork) : sheet_(artwork.sheet) {
    cell_ = (sheet_.high - sheet_.low) / kCells;
    require(cell_.minCoeff() > 0, "ArtworkIndex: the artwork has no sheet");
    cells_.resize(std::size_t(kCells) * kCells);
    const auto add = [&](const Vec2& low, const Vec2& high, const auto& put) {
      for (int y = index(low, 1); y <= index(high, 1); ++y)
        for (int x = index(low, 0); x <= index(high, 0); ++x) put(cells_[std::size_t(y * kCells + x)]);
    };
    for (const ArtworkRectangle& r : artwork.rectangles)
      add(r.low, r.high, [&](BoardArtwork& cell) { cell.rectangles.push_back(r); });
    for (const ArtworkDisc& d : artwork.discs)
      add(d.centre - Vec2::Constant(d.radius), d.centre + Vec2::Constant(d.radius),
          [&](BoardArtwork& cell) { cell.discs.push_back(d); });
  }

  const ArtworkRectangle& sheet() const { return sheet_; }
  bool is_dark(const Vec2& p) const {
    return sheet_.contains(p) && cells_[std::size_t(index(p, 1) * kCells + index(p, 0))].is_dark(p);
  }
  /// Share of a box that is dark, exactly: every cell's part of the box by itself, as a shape lies in many.
  double dark_share(const Vec2& low, const Vec2& high) const {
    double area = 0;
    for (int y = index(low, 1); y <= index(high, 1); ++y)
      for (int x = index(low, 0); x <= index(high, 0); ++x) {
        const BoardArtwork& cell = cells_[std::size_t(y * kCells + x)];
        if (cell.rectangles.empty() && cell.discs.empty()) continue;
        const Vec2 corner = sheet_.low + Vec2(x, y).cwiseProduct(cell_);
        const Vec2 a = low.cwiseMax(corner), b = high.cwiseMin(corner + cell_);
        if (!(a.x() < b.x() && a.y() < b.y())) continue;
        for (const ArtworkRectangle& r : cell.rectangles)
          area += (b.cwiseMin(r.high) - a.cwiseMax(r.low)).cwiseMax(0.0).prod();
        for (const ArtworkDisc& d : cell.discs)
          area += area_of_disc_in_box(d.radius, a - d.centre, b - d.centre);
      }
    return area / (high - low).prod();
  }

 private:
  static constexpr int kCells = 64;
  int index(const Vec2& p, int axis) const {
    return std::clamp(int(std::floor((p[axis] - sheet_.low[axis]) / cell_[axis])), 0, kCells - 1);
  }

  ArtworkRectangle sheet_;
  Vec2 cell_;
  std::vector<BoardArtwork> cells_;
};

}  // namespace procam
