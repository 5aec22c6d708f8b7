#include "grid_neighbourhood.hpp"

#include <algorithm>
#include <cmath>

namespace procam::detect {
namespace {

constexpr double kSigmaWithoutFit = 0.5;  // pixels

struct LineDerivatives {
  Vec2 first, second;   ///< of the position by squares along the line
  double variance = 0;  ///< of the second, across the line
};

/// At corner `i` of a line of `n`. `at` and `variance` take the index of a corner.
template <typename At, typename Variance>
LineDerivatives along_line(int n, int i, const At& at, const Variance& variance) {
  const auto second_at = [&](int k) { return Vec2(at(k - 1) - 2 * at(k) + at(k + 1)); };
  const auto is_centre = [&](int k) { return k >= 1 && k <= n - 2; };
  LineDerivatives best;
  for (const int k : {i, i - 1, i + 1}) {
    if (!is_centre(k)) continue;
    double squared = variance(k - 1) + 4 * variance(k) + variance(k + 1);
    const Vec2 second = second_at(k), first = 0.5 * (at(k + 1) - at(k - 1)) + (i - k) * second;
    if (k != i) {
      const int beyond = 2 * k - i;
      const Vec2 change = is_centre(beyond) ? Vec2(second_at(beyond) - second) : second;
      const double across = (first.x() * change.y() - first.y() * change.x()) / first.norm();
      squared += across * across;
    }
    if (best.variance > 0 && squared >= best.variance) continue;
    best = {first, second, squared};
  }
  return best;
}

/// The second derivative averaged with those of the lines on both sides, which weigh alike: a change across the
/// lines cancels.
LineDerivatives averaged(LineDerivatives line, const LineDerivatives& before, const LineDerivatives& after) {
  const double own = 1 / line.variance, other = 1 / std::max(before.variance, after.variance);
  line.variance = 1 / (own + 2 * other);
  line.second = line.variance * (own * line.second + other * (before.second + after.second));
  return line;
}

}  // namespace

CornerNeighbourhood neighbourhood_in_grid(const CornerGrid& grid,
                                          const std::vector<std::optional<CornerFit>>& fits, int column,
                                          int row) {
  const auto variance = [&](int c, int r) {
    const std::size_t i = std::size_t(r * grid.columns + c);
    return !fits.empty() && fits[i] ? 0.5 * fits[i]->covariance.trace() : kSigmaWithoutFit * kSigmaWithoutFit;
  };
  const auto along_row = [&](int r) {
    return along_line(
        grid.columns, column, [&](int c) { return grid.at(c, r); }, [&](int c) { return variance(c, r); });
  };
  const auto along_column = [&](int c) {
    return along_line(
        grid.rows, row, [&](int r) { return grid.at(c, r); }, [&](int r) { return variance(c, r); });
  };
  LineDerivatives x = along_row(row), y = along_column(column);
  if (row > 0 && row < grid.rows - 1) x = averaged(x, along_row(row - 1), along_row(row + 1));
  if (column > 0 && column < grid.columns - 1)
    y = averaged(y, along_column(column - 1), along_column(column + 1));
  CornerNeighbourhood around;
  around.corner = grid.at(column, row);
  around.e_x = x.first, around.e_y = y.first;
  around.e_xx = x.second, around.e_yy = y.second;
  around.sigma_xx = std::sqrt(x.variance), around.sigma_yy = std::sqrt(y.variance);
  return around;
}

}  // namespace procam::detect
