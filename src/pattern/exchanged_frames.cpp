#include "exchanged_frames.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include "gray_code_bits.hpp"

namespace procam::pattern::internal {
namespace {

constexpr int kAxes = 2;
constexpr std::array<StripeAxis, kAxes> kAxisOf = {StripeAxis::kColumn, StripeAxis::kRow};

/// The bits as they are shown, of both axes.
using Word = std::array<std::uint16_t, kAxes>;

struct Step {
  Word from, to;
};

/// Steps from a pixel to the next one of its line and of its column, and to the one some lines below: the border of a coarse
/// stripe may lie between two lines that are read.
enum Direction { kAlongLine, kToNextLine, kToFarLine };
constexpr int kDirections = 3;

struct Sample {
  std::array<int, kAxes> bits = {};     ///< of an axis
  std::array<int, kAxes> dropped = {};  ///< the finest ones, which the camera does not resolve
  std::array<std::vector<Step>, kDirections> steps;
};

struct BitOf {
  int axis, bit;
};

int first_capture(const Sample& sample, const BitOf& of) {
  return 2 * ((of.axis == 0 ? 0 : sample.bits[0]) + sample.bits[std::size_t(of.axis)] - 1 - of.bit);
}

/// Pairs of lines, and of each pixel by how many bits of an axis are decided, from the coarsest on.
Sample read_sample(const std::vector<ViewU8>& captures, const GrayCode& gray_code) {
  constexpr int kLines = 16, kLit = 20, kDecided = 8;  // grey levels
  constexpr int kResolvedPercent = 60;
  Sample sample;
  for (std::size_t axis = 0; axis < kAxes; ++axis) sample.bits[axis] = bit_count(gray_code, kAxisOf[axis]);
  const ViewU8 &white = captures[captures.size() - 2], &black = captures.back();
  struct Read {
    Word word = {};
    std::array<std::uint8_t, kAxes> undecided = {};  ///< number of finest bits
    bool lit = false;
  };
  std::vector<Read> pixels;
  const auto width = std::size_t(white.width);
  for (int y = kLines / 2; y + 1 < white.height; y += kLines)
    for (int line = y; line <= y + 1; ++line) {
      const std::size_t begin = pixels.size();
      pixels.resize(begin + width);
      for (std::size_t x = 0; x < width; ++x)
        pixels[begin + x].lit = white.row(line)[x] - black.row(line)[x] >= kLit;
      for (int axis = 0; axis < kAxes; ++axis)
        for (int bit = sample.bits[std::size_t(axis)] - 1; bit >= 0; --bit) {
          const auto first = std::size_t(first_capture(sample, {axis, bit}));
          const std::uint8_t *pattern = captures[first].row(line), *inverse = captures[first + 1].row(line);
          for (std::size_t x = 0; x < width; ++x) {
            Read& pixel = pixels[begin + x];
            const int difference = pattern[x] - inverse[x];
            if (difference > 0) pixel.word[std::size_t(axis)] |= std::uint16_t(1u << bit);
            if (std::abs(difference) < kDecided)
              pixel.undecided[std::size_t(axis)] =
                  std::max(pixel.undecided[std::size_t(axis)], std::uint8_t(bit + 1));
          }
        }
    }
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    std::array<long, 17> count = {};
    long lit = 0;
    for (const Read& pixel : pixels)
      if (pixel.lit) ++lit, ++count[pixel.undecided[axis]];
    long resolved = count[0];
    int& dropped = sample.dropped[axis];
    while (dropped < sample.bits[axis] && 100 * resolved < kResolvedPercent * lit)
      resolved += count[std::size_t(++dropped)];
  }
  const auto is_read = [&](const Read& pixel) {
    return pixel.lit && pixel.undecided[0] <= sample.dropped[0] && pixel.undecided[1] <= sample.dropped[1];
  };
  for (std::size_t begin = 0; begin < pixels.size(); begin += 2 * width)
    for (std::size_t x = 0; x < width; ++x) {
      const std::size_t at = begin + x;
      if (!is_read(pixels[at])) continue;
      const auto add_step = [&](Direction direction, std::size_t to) {
        if (to < pixels.size() && is_read(pixels[to]))
          sample.steps[direction].push_back({pixels[at].word, pixels[to].word});
      };
      if (x + 1 < width) add_step(kAlongLine, at + 1);
      add_step(kToNextLine, at + width);
      add_step(kToFarLine, at + 2 * width);
    }
  return sample;
}

int stripe_of(unsigned reflected) {
  for (const int shift : {8, 4, 2, 1}) reflected ^= reflected >> shift;
  return int(reflected);
}

int step_length(const Sample& sample, std::size_t axis, unsigned from, unsigned to) {
  return (stripe_of(to) >> sample.dropped[axis]) - (stripe_of(from) >> sample.dropped[axis]);
}

/// Puts frames back: a bit's pattern and its inverse, or two bits.
struct Exchange {
  BitOf bit;
  std::optional<BitOf> with;

  static bool is_set(const Word& word, const BitOf& of) {
    return ((word[std::size_t(of.axis)] >> of.bit) & 1) != 0;
  }
  static void flip(Word& word, const BitOf& of) { word[std::size_t(of.axis)] ^= std::uint16_t(1u << of.bit); }
  Word operator()(Word word) const {
    if (with && is_set(word, bit) == is_set(word, *with)) return word;
    flip(word, bit);
    if (with) flip(word, *with);
    return word;
  }
  bool concerns(std::size_t axis) const {
    return std::size_t(bit.axis) == axis || (with && std::size_t(with->axis) == axis);
  }
};

constexpr auto kAsGiven = [](const Word& word) { return word; };

/// T of near pixels and of far ones.
using Extent = std::array<double, 2>;

/// Of one axis.
template <class Repair>
Extent extent(const Sample& sample, std::size_t axis, const Repair& repair) {
  constexpr std::size_t kMany = 7000;
  Extent total = {};
  for (std::size_t direction = 0; direction < kDirections; ++direction) {
    const std::vector<Step>& steps = sample.steps[direction];
    const std::size_t every = 1 + steps.size() / kMany;
    for (std::size_t i = 0; i < steps.size(); i += every)
      total[direction == kToFarLine] +=
          double(every) *
          std::abs(step_length(sample, axis, repair(steps[i].from)[axis], repair(steps[i].to)[axis]));
  }
  return total;
}

/// Along the lines or the columns of the image, those that cross more stripes: codes in the right order rise or fall.
template <class Repair>
bool go_one_way(const Sample& sample, std::size_t axis, const Repair& repair) {
  constexpr double kOneWay = 1.4;
  std::array<double, kDirections> length = {}, sum = {};
  for (std::size_t direction = 0; direction < kDirections; ++direction)
    for (const Step& step : sample.steps[direction]) {
      const int by = step_length(sample, axis, repair(step.from)[axis], repair(step.to)[axis]);
      length[direction] += std::abs(by), sum[direction] += by;
    }
  const auto is_one_way = [&](Direction direction) {
    return length[direction] <= kOneWay * std::abs(sum[direction]);
  };
  if (length[kAlongLine] > length[kToNextLine]) return is_one_way(kAlongLine);
  return is_one_way(kToNextLine) && is_one_way(kToFarLine);
}

}  // namespace

std::optional<ExchangedFrames> find_exchanged_frames(const std::vector<ViewU8>& captures,
                                                     const GrayCode& gray_code) {
  constexpr std::size_t kFew = 1000;
  constexpr double kFarLess = 0.7;  // the finest bit's exchange doubles T, others make it three times as much
  constexpr double kNoMore = 1.1;   // of the other pixels' T
  const Sample sample = read_sample(captures, gray_code);
  if (sample.steps[kAlongLine].size() < kFew) return std::nullopt;
  if (go_one_way(sample, 0, kAsGiven) && go_one_way(sample, 1, kAsGiven)) return std::nullopt;
  std::array<Extent, kAxes> as_given;
  for (std::size_t axis = 0; axis < kAxes; ++axis) as_given[axis] = extent(sample, axis, kAsGiven);

  std::optional<Exchange> best;
  double least = kFarLess;
  const auto consider = [&](const Exchange& exchange) {
    Extent given = {}, repaired = {};
    for (std::size_t axis = 0; axis < kAxes; ++axis) {
      if (!exchange.concerns(axis)) continue;
      const Extent of_axis = extent(sample, axis, exchange);
      for (const std::size_t of : {0, 1}) given[of] += as_given[axis][of], repaired[of] += of_axis[of];
    }
    const double near = repaired[0] / std::max(given[0], 1.0), far = repaired[1] / std::max(given[1], 1.0);
    if (std::min(near, far) >= least || std::max(near, far) > kNoMore) return;
    least = std::min(near, far);
    best = exchange;
  };
  std::vector<BitOf> bits;
  for (int axis = 0; axis < kAxes; ++axis)
    for (int bit = sample.dropped[std::size_t(axis)]; bit < sample.bits[std::size_t(axis)]; ++bit)
      bits.push_back({axis, bit});
  for (std::size_t i = 0; i < bits.size(); ++i) {
    consider({bits[i], std::nullopt});
    for (std::size_t j = 0; j < i; ++j) consider({bits[i], bits[j]});
  }
  if (!best) return std::nullopt;
  // A camera that shakes scatters codes as well: these go to and fro whatever is exchanged.
  for (std::size_t axis = 0; axis < kAxes; ++axis)
    if (best->concerns(axis) && !go_one_way(sample, axis, *best)) return std::nullopt;
  const int capture = first_capture(sample, best->bit);
  if (!best->with) return ExchangedFrames{capture, capture + 1, false};
  const auto [first, second] = std::minmax({capture, first_capture(sample, *best->with)});
  return ExchangedFrames{first, second, true};
}

}  // namespace procam::pattern::internal
