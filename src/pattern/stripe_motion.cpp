#include "stripe_motion.hpp"

#include <algorithm>
#include <cmath>
#include <vector>
#include "gray_code_bits.hpp"

namespace procam::pattern::internal {
namespace {

/// Pattern minus inverse along a row or a column of the image, by white minus black.
struct Line {
  const Sequence& sequence;
  bool is_row;
  int index;

  int length() const { return is_row ? sequence.size().width : sequence.size().height; }
  double value(int pair, int t) const {
    const int x = is_row ? t : index, y = is_row ? index : t;
    const double contrast = sequence.white(x, y) - sequence.black(x, y);
    const FramePair& of = sequence.pair(pair);
    return (sequence.at(of.first, x, y) - sequence.at(of.second, x, y)) / std::max(contrast, 1.0);
  }
  bool is_lit(int t) const {
    const int x = is_row ? t : index, y = is_row ? index : t;
    return sequence.white_grey().at(x, y) <= 250 && sequence.white(x, y) - sequence.black(x, y) > kMinLight;
  }
  /// Where the sign changes between t and t + 1.
  double crossing(int pair, int t) const {
    const double a = value(pair, t), b = value(pair, t + 1);
    return t + a / (a - b);
  }
  bool changes(int pair, int t) const { return value(pair, t) * value(pair, t + 1) < 0; }

  static constexpr double kMinLight = 4;
};

constexpr int kReach = 40;               // pixels to the fine stripe's edges
constexpr double kClear = 0.4;           // of the contrast, beside the coarse edge and in the fine stripe
constexpr int kBeside = 3;               // pixels
constexpr std::size_t kFewOffsets = 30;  // edges
constexpr double kFineStripe = 16;

/// Offset of a coarse edge at t from the middle of the fine stripe, in fine stripes.
std::optional<double> offset_at(const Line& line, int coarse, int fine, int t) {
  if (t - kBeside < 0 || t + 1 + kBeside >= line.length()) return std::nullopt;
  const double before = line.value(coarse, t - kBeside), after = line.value(coarse, t + 1 + kBeside);
  if (before * after > 0 || std::min(std::abs(before), std::abs(after)) < kClear) return std::nullopt;
  if (std::abs(line.value(fine, t)) < kClear) return std::nullopt;
  std::optional<double> left, right;
  for (int i = 0; i < kReach && t - 1 - i >= 0 && line.is_lit(t - 1 - i) && !left; ++i)
    if (line.changes(fine, t - 1 - i)) left = line.crossing(fine, t - 1 - i);
  for (int i = 0; i < kReach && t + 2 + i < line.length() && line.is_lit(t + 2 + i) && !right; ++i)
    if (line.changes(fine, t + 1 + i)) right = line.crossing(fine, t + 1 + i);
  if (!left || !right || *right - *left < 2 * kBeside) return std::nullopt;
  return (line.crossing(coarse, t) - 0.5 * (*left + *right)) / (*right - *left);
}

}  // namespace

std::optional<double> stripe_motion(const Sequence& sequence, const GrayCode& gray_code, StripeAxis axis) {
  const int bits = bit_count(gray_code, axis);
  const int first = axis == StripeAxis::kColumn ? 0 : bit_count(gray_code, StripeAxis::kColumn);
  int fine_bit = 0;
  while (gray_code.step * std::pow(2, fine_bit + 1) < kFineStripe) ++fine_bit;
  const double stripe = gray_code.step * std::pow(2, fine_bit + 1);
  const int fine = first + bits - 1 - fine_bit;
  // Columns are edges along the rows of an upright projector's image, and along the columns of one on its
  // side.
  std::vector<double> found;
  for (int coarse = first; coarse < fine && found.size() < 2; ++coarse) {
    std::vector<double> offsets;
    for (const bool is_row : {true, false}) {
      std::vector<double> along;
      const int lines = is_row ? sequence.size().height : sequence.size().width;
      for (int index = 4; index < lines; index += 4) {
        const Line line{sequence, is_row, index};
        for (int t = kBeside; t + kBeside + 1 < line.length(); ++t)
          if (line.is_lit(t) && line.is_lit(t + 1) && line.changes(coarse, t))
            if (const auto offset = offset_at(line, coarse, fine, t)) along.push_back(*offset);
      }
      if (along.size() > offsets.size()) offsets = std::move(along);
    }
    if (offsets.size() >= kFewOffsets) found.push_back(stripe * usual(std::move(offsets)).value);
  }
  if (found.size() < 2) return std::nullopt;
  if (found[0] * found[1] < 0) return 0;
  return std::min(std::abs(found[0]), std::abs(found[1]));
}

}  // namespace procam::pattern::internal
