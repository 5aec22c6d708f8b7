#include "procam/session/change.hpp"
#include "procam/core/base/stats.hpp"

#include <algorithm>
#include <cmath>

namespace procam::session {
namespace {

constexpr int kBlock = 16;
constexpr double kSigmas = 6.5;
constexpr double kFloor = 1;  // grey levels
constexpr double kRounding = 1.0 / 12;

struct BlockDifference {
  double mean_grey = 0;
  double mean_square = 0;
  int pixels = 0;
};

/// Calls `use` for every block; those at the right and lower rim are smaller, slivers are skipped.
template <typename Use>
void for_each_block(ViewU8 a, ViewU8 b, const Use& use) {
  for (int top = 0; top < a.height; top += kBlock)
    for (int left = 0; left < a.width; left += kBlock) {
      const int bottom = std::min(top + kBlock, a.height), right = std::min(left + kBlock, a.width);
      BlockDifference block;
      block.pixels = (bottom - top) * (right - left);
      if (block.pixels < kBlock) continue;
      long long sum = 0, squares = 0;
      for (int y = top; y < bottom; ++y) {
        const std::uint8_t *pa = a.row(y), *pb = b.row(y);
        for (int x = left; x < right; ++x) {
          const int difference = int(pa[x]) - int(pb[x]);
          sum += int(pa[x]) + int(pb[x]);
          squares += difference * difference;
        }
      }
      block.mean_grey = 0.5 * double(sum) / block.pixels;
      block.mean_square = double(squares) / block.pixels;
      use(block);
    }
}

/// The factor over the mean that a chi^2 variable with n degrees of freedom exceeds at kSigmas.
double chi_square_limit(int n) {
  const double spread = 2.0 / (9.0 * n), root = 1 - spread + kSigmas * std::sqrt(spread);
  return root * root * root;
}

}  // namespace

Change compare(ViewU8 a, ViewU8 b, const NoiseModel& noise) {
  require(a.size() == b.size() && a.channels == 1 && b.channels == 1,
          "compare: two grey images of one size are needed");
  int blocks = 0, changed = 0;
  Change change;
  for_each_block(a, b, [&](const BlockDifference& block) {
    ++blocks;
    const double expected = 2 * noise.variance(block.mean_grey);
    if (block.mean_square <= expected * chi_square_limit(block.pixels) + kFloor * kFloor) return;
    ++changed;
    change.largest = std::max(change.largest, std::sqrt(block.mean_square - expected));
  });
  change.share = blocks > 0 ? double(changed) / blocks : 0;
  return change;
}

NoiseModel measure_noise(const std::vector<ViewU8>& frames) {
  require(frames.size() >= 2, "measure_noise: two frames are needed");
  std::vector<BlockDifference> blocks;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    require(frames[i].size() == frames[0].size(), "measure_noise: frames of two sizes");
    for_each_block(frames[i - 1], frames[i], [&](const BlockDifference& block) { blocks.push_back(block); });
  }
  NoiseModel noise{kRounding, 0};
  if (blocks.empty()) return noise;
  // Medians of groups of equal brightness, then a line through them.
  std::sort(blocks.begin(), blocks.end(),
            [](const BlockDifference& a, const BlockDifference& b) { return a.mean_grey < b.mean_grey; });
  constexpr std::size_t kGroups = 8;
  double n = 0, g = 0, v = 0, gg = 0, gv = 0;
  for (std::size_t group = 0; group < kGroups; ++group) {
    const std::size_t first = blocks.size() * group / kGroups, last = blocks.size() * (group + 1) / kGroups;
    if (first == last) continue;
    std::vector<double> greys, variances;
    for (std::size_t i = first; i < last; ++i) {
      greys.push_back(blocks[i].mean_grey);
      variances.push_back(0.5 * blocks[i].mean_square);
    }
    const double grey = median(greys), variance = median(variances);
    n += 1, g += grey, v += variance, gg += grey * grey, gv += grey * variance;
  }
  const double spread = gg - g * g / n;
  constexpr double kNarrow = 1;  // grey levels^2: too little to tell a slope
  noise.per_level = spread > kNarrow ? std::max(0.0, (gv - g * v / n) / spread) : 0;
  noise.at_black = std::max(kRounding, (v - noise.per_level * g) / n);
  return noise;
}

}  // namespace procam::session
