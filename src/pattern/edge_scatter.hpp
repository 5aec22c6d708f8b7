#pragma once
/// How far stripe edges are off the lines through their neighbours, over what the images' noise explains: over the whole
/// image, and by tiles.
///
/// Light that comes by way of another surface moves edges by its share of the direct light: a lacquered table that mirrors a
/// striped wall. There neighbouring edges disagree more than elsewhere, and their standard deviations are larger by as much.
#include <algorithm>
#include <cmath>
#include <vector>

#include "procam/core/base/stats.hpp"
#include "procam/core/base/types.hpp"

namespace procam::pattern::internal {

class EdgeScatter {
 public:
  explicit EdgeScatter(ImageSize size)
      : columns_((size.width + kTile - 1) / kTile),
        rows_((size.height + kTile - 1) / kTile),
        ratios_(std::size_t(columns_) * std::size_t(rows_)) {}

  /// Distance from the line over that of noise, at a camera pixel.
  void add(const Vec2& at, double ratio) { ratios_[tile(at)].push_back(ratio); }

  /// Once all are added.
  void finish() {
    std::vector<double> all;
    for (const auto& of_tile : ratios_) all.insert(all.end(), of_tile.begin(), of_tile.end());
    everywhere_ = std::max(1.0, median_or(std::move(all), kMedianOfNoise) / kMedianOfNoise);
    factors_.assign(ratios_.size(), everywhere_);
    for (int row = 0; row < rows_; ++row)
      for (int column = 0; column < columns_; ++column) {
        std::vector<double> around = ratios_around(column, row);
        if (around.size() < kFewest) continue;
        const double here = median(std::move(around)) / kMedianOfNoise;
        if (here > kOtherLight * everywhere_) factors_[index(column, row)] = here;
      }
  }

  /// Factor on the standard deviations of the edges of the whole image, and of those around a pixel.
  double everywhere() const { return everywhere_; }
  double factor(const Vec2& at) const { return factors_[tile(at)]; }

 private:
  static constexpr int kTile = 16;  ///< camera pixels a side; a factor is that of 3 x 3 tiles
  static constexpr std::size_t kFewest = 50;
  /// Chance is far below: the median of 50 has a standard error of 17 %. Blur and the projector's pixels make differences below
  /// 1.5, which average out over neighbouring edges.
  static constexpr double kOtherLight = 1.5;
  static constexpr double kMedianOfNoise = 0.67448975;  ///< of |N(0, 1)|

  std::vector<double> ratios_around(int column, int row) const {
    std::vector<double> around;
    for (int j = std::max(0, row - 1); j <= std::min(rows_ - 1, row + 1); ++j)
      for (int i = std::max(0, column - 1); i <= std::min(columns_ - 1, column + 1); ++i) {
        const std::vector<double>& of_tile = ratios_[index(i, j)];
        around.insert(around.end(), of_tile.begin(), of_tile.end());
      }
    return around;
  }
  std::size_t index(int column, int row) const {
    return std::size_t(row) * std::size_t(columns_) + std::size_t(column);
  }
  std::size_t tile(const Vec2& at) const {
    return index(std::clamp(int(at.x()) / kTile, 0, columns_ - 1),
                 std::clamp(int(at.y()) / kTile, 0, rows_ - 1));
  }

  int columns_, rows_;
  std::vector<std::vector<double>> ratios_;
  double everywhere_ = 1;
  std::vector<double> factors_;
};

}  // namespace procam::pattern::internal
