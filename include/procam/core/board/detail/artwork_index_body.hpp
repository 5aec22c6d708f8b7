#pragma once
/// The bodies of artwork_index.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include <algorithm>
#include <cmath>

#include "procam/core/board/artwork_index.hpp"

namespace procam {

PROCAM_CORE_INLINE double area_of_disc_in_box(double radius, const Vec2& low, const Vec2& high) {
  const double left = std::max(low.x(), -radius), right = std::min(high.x(), radius);
  if (!(left < right) || low.y() >= radius || high.y() <= -radius) return 0;
  std::vector<double> cuts{left, right};
  for (const double y : {low.y(), high.y()})
    if (std::abs(y) < radius)
      for (const double x : {-std::sqrt(radius * radius - y * y), std::sqrt(radius * radius - y * y)})
        if (x > left && x < right) cuts.push_back(x);
  std::sort(cuts.begin(), cuts.end());
  // As a product: where the compiler fuses r^2 - x^2, the rounded square leaves sqrt(1e-17) at x = r.
  const auto rim = [&](double x) { return std::sqrt(std::max(0.0, (radius - x) * (radius + x))); };
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

PROCAM_CORE_INLINE ArtworkIndex::ArtworkIndex(const BoardArtwork& artwork) : sheet_(artwork.sheet) {
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

PROCAM_CORE_INLINE double ArtworkIndex::dark_share(const Vec2& low, const Vec2& high) const {
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

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
