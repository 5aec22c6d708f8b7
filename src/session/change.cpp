#include "procam/session/change.hpp"
#include "procam/core/base/stats.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

namespace procam::session {
namespace {

constexpr int kBlock = 16;
constexpr double kSigmas = 6.5;
constexpr double kFloor = 1;  // grey levels
constexpr double kRounding = 1.0 / 12;

/// Pixels of a block by the knot of the noise model that is nearest to their mean grey of both frames.
struct BlockDifference {
  double mean_grey = 0;
  double mean_square = 0;
  int pixels = 0;
  std::array<int, NoiseModel::kKnots> count = {};
  std::array<long long, NoiseModel::kKnots> squares = {};
  std::array<std::uint16_t, 256> greys = {};  ///< pixels by their mean grey, rounded down
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
          const int difference = int(pa[x]) - int(pb[x]), twice = int(pa[x]) + int(pb[x]);
          const std::size_t knot = std::size_t(twice + NoiseModel::kSpacing) / (2 * NoiseModel::kSpacing);
          sum += twice;
          squares += difference * difference;
          ++block.greys[std::size_t(twice / 2)];
          ++block.count[knot];
          block.squares[knot] += difference * difference;
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
  // By pixel: where dark pixels are the noisiest, a block of dark and bright ones has more noise than its mean grey.
  std::array<double, 256> variance{};
  for (std::size_t grey = 0; grey < 256; ++grey) variance[grey] = noise.variance(double(grey));
  for_each_block(a, b, [&](const BlockDifference& block) {
    ++blocks;
    double expected = 0;
    for (std::size_t grey = 0; grey < 256; ++grey)
      if (block.greys[grey] > 0) expected += block.greys[grey] * variance[grey];
    expected *= 2.0 / block.pixels;
    if (block.mean_square <= expected * chi_square_limit(block.pixels) + kFloor * kFloor) return;
    ++changed;
    change.largest = std::max(change.largest, std::sqrt(block.mean_square - expected));
  });
  change.share = blocks > 0 ? double(changed) / blocks : 0;
  return change;
}

namespace {

/// variance = at_black + per_level * grey by medians of groups of equal brightness.
NoiseModel fit_line(std::vector<BlockDifference>& blocks) {
  NoiseModel noise{kRounding, 0};
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

using PairBlocks = std::vector<BlockDifference>;  ///< of one pair of frames, block by block

/// The variance of a block's pixels near a knot: the lower median over the pairs of a scene. None unless most pairs have
/// such pixels: those that only torn frames show are no noise.
std::optional<double> variance_at(const std::vector<PairBlocks>& pairs, std::size_t block, std::size_t knot) {
  constexpr int kFewest = 24;  // pixels
  std::vector<double> variances;
  for (const PairBlocks& pair : pairs)
    if (pair[block].count[knot] >= kFewest)
      variances.push_back(0.5 * double(pair[block].squares[knot]) / pair[block].count[knot]);
  if (2 * variances.size() <= pairs.size()) return std::nullopt;
  return quantile(std::move(variances), 0.5);
}

/// What the line leaves at each knot: the median over all blocks. Knots without pixels take the nearest one's.
void add_departures(const std::vector<std::vector<PairBlocks>>& scenes, NoiseModel& noise) {
  constexpr std::size_t kFewestBlocks = 5;
  std::array<std::optional<double>, NoiseModel::kKnots> known;
  for (std::size_t knot = 0; knot < known.size(); ++knot) {
    std::vector<double> variances;
    for (const std::vector<PairBlocks>& pairs : scenes)
      for (std::size_t block = 0; block < pairs.front().size(); ++block)
        if (const auto variance = variance_at(pairs, block, knot)) variances.push_back(*variance);
    if (variances.size() < kFewestBlocks) continue;
    known[knot] = median(variances) - noise.at_black - noise.per_level * double(knot * NoiseModel::kSpacing);
  }
  for (int knot = 0; knot < NoiseModel::kKnots; ++knot)
    for (int away = 0; away < NoiseModel::kKnots; ++away) {
      const int below = knot - away, above = knot + away;
      const auto at = [&](int k) {
        return k >= 0 && k < NoiseModel::kKnots ? known[std::size_t(k)] : std::nullopt;
      };
      const std::optional<double> nearest = at(below) ? at(below) : at(above);
      if (!nearest) continue;
      noise.departure[std::size_t(knot)] = *nearest;
      break;
    }
}

}  // namespace

NoiseModel measure_noise_of_scenes(const std::vector<std::vector<ViewU8>>& scenes) {
  std::vector<std::vector<PairBlocks>> measured;
  std::vector<BlockDifference> all;
  for (const std::vector<ViewU8>& frames : scenes) {
    require(frames.size() >= 2, "measure_noise: two frames are needed");
    std::vector<PairBlocks>& pairs = measured.emplace_back();
    for (std::size_t i = 1; i < frames.size(); ++i) {
      require(frames[i].size() == frames[0].size(), "measure_noise: frames of two sizes");
      PairBlocks& blocks = pairs.emplace_back();
      for_each_block(frames[i - 1], frames[i],
                     [&](const BlockDifference& block) { blocks.push_back(block); });
      all.insert(all.end(), blocks.begin(), blocks.end());
    }
  }
  if (all.empty()) return {kRounding, 0};
  NoiseModel noise = fit_line(all);
  add_departures(measured, noise);
  return noise;
}

NoiseModel measure_noise(const std::vector<ViewU8>& frames) {
  return measure_noise_of_scenes({frames});
}

}  // namespace procam::session
