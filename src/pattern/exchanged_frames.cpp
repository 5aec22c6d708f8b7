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

struct Neighbours {
  Word a, b;
  bool across;  ///< along a line of the image; else the one below
};

struct Sample {
  std::array<int, kAxes> bits = {};     ///< of an axis
  std::array<int, kAxes> dropped = {};  ///< the finest ones, which the camera does not resolve
  std::vector<Neighbours> neighbours;
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
      const Read& a = pixels[begin + x];
      if (!is_read(a)) continue;
      if (x + 1 < width && is_read(pixels[begin + x + 1]))
        sample.neighbours.push_back({a.word, pixels[begin + x + 1].word, true});
      if (is_read(pixels[begin + width + x]))
        sample.neighbours.push_back({a.word, pixels[begin + width + x].word, false});
    }
  return sample;
}

int stripe_of(unsigned reflected) {
  for (const int shift : {8, 4, 2, 1}) reflected ^= reflected >> shift;
  return int(reflected);
}

/// The words of one axis after an exchange.
template <class Repair>
long total_steps(const Sample& sample, std::size_t axis, std::size_t every, const Repair& repair) {
  long total = 0;
  const int dropped = sample.dropped[axis];
  for (std::size_t i = 0; i < sample.neighbours.size(); i += every)
    total += std::abs((stripe_of(repair(sample.neighbours[i].a)[axis]) >> dropped) -
                      (stripe_of(repair(sample.neighbours[i].b)[axis]) >> dropped));
  return total;
}

/// Along the lines of the image, or along its columns: codes in the right order rise or fall.
bool codes_rise_and_fall(const Sample& sample) {
  constexpr double kOneWay = 1.4;
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    std::array<double, 2> steps = {}, sum = {};
    for (const Neighbours& n : sample.neighbours) {
      const int step =
          (stripe_of(n.b[axis]) >> sample.dropped[axis]) - (stripe_of(n.a[axis]) >> sample.dropped[axis]);
      steps[n.across] += std::abs(step), sum[n.across] += step;
    }
    const std::size_t along = steps[1] > steps[0];
    if (steps[along] > kOneWay * std::abs(sum[along])) return true;
  }
  return false;
}

}  // namespace

std::optional<ExchangedFrames> find_exchanged_frames(const std::vector<ViewU8>& captures,
                                                     const GrayCode& gray_code) {
  constexpr std::size_t kFew = 2000, kMany = 20000;
  constexpr double kFarLess = 0.7;  // where half of a pattern's pixels change by one stripe, T halves
  const Sample sample = read_sample(captures, gray_code);
  if (sample.neighbours.size() < kFew || !codes_rise_and_fall(sample)) return std::nullopt;
  const std::size_t every = 1 + sample.neighbours.size() / kMany;
  std::array<double, kAxes> as_given = {};
  for (std::size_t axis = 0; axis < kAxes; ++axis)
    as_given[axis] = double(total_steps(sample, axis, every, [](const Word& word) { return word; }));

  std::optional<ExchangedFrames> best;
  double least = kFarLess;
  const auto consider = [&](const ExchangedFrames& exchanged, double given, double repaired) {
    if (repaired >= least * given) return;
    least = repaired / given;
    best = exchanged;
  };
  std::vector<BitOf> bits;
  for (int axis = 0; axis < kAxes; ++axis)
    for (int bit = sample.dropped[std::size_t(axis)]; bit < sample.bits[std::size_t(axis)]; ++bit)
      bits.push_back({axis, bit});
  for (std::size_t i = 0; i < bits.size(); ++i) {
    const BitOf a = bits[i];
    const auto axis = std::size_t(a.axis);
    const int capture = first_capture(sample, a);
    const auto inverted = [&](Word word) {
      word[axis] ^= std::uint16_t(1u << a.bit);
      return word;
    };
    consider({capture, capture + 1, false}, as_given[axis],
             double(total_steps(sample, axis, every, inverted)));
    for (std::size_t j = 0; j < i; ++j) {
      const BitOf b = bits[j];
      const auto other = std::size_t(b.axis);
      const auto swapped = [&](Word word) {
        if ((((word[axis] >> a.bit) ^ (word[other] >> b.bit)) & 1) != 0) {
          word[axis] ^= std::uint16_t(1u << a.bit);
          word[other] ^= std::uint16_t(1u << b.bit);
        }
        return word;
      };
      double given = as_given[axis], repaired = double(total_steps(sample, axis, every, swapped));
      if (other != axis)
        given += as_given[other], repaired += double(total_steps(sample, other, every, swapped));
      const auto [first, second] = std::minmax({capture, first_capture(sample, b)});
      consider({first, second, true}, given, repaired);
    }
  }
  return best;
}

}  // namespace procam::pattern::internal
