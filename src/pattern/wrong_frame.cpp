#include "wrong_frame.hpp"
#include "procam/core/base/stats.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace procam::pattern::internal {
namespace {

using Bands = std::array<double, kBands>;  // below zero: unknown

/// Mean square of a difference by band, share of the squared contrast.
template <class Difference>
Bands squares_by_band(const Sequence& sequence, const FramePair& captures, const Difference& difference) {
  Bands squares{}, contrasts{};
  std::array<int, kBands> counts{};
  for (const Pixel& p : sequence.shown()) {
    if (!sequence.is_below_full_scale(captures, p)) continue;
    const auto band = std::size_t(sequence.band(p));
    const double contrast = sequence.white(p.x, p.y) - sequence.black(p.x, p.y);
    const double d = difference(p, band);
    squares[band] += std::min(d * d, contrast * contrast);
    contrasts[band] += contrast * contrast;
    ++counts[band];
  }
  constexpr int kFew = 40;
  for (std::size_t i = 0; i < kBands; ++i) squares[i] = counts[i] < kFew ? -1 : squares[i] / contrasts[i];
  return squares;
}

Bands alike(const Sequence& sequence, int a, int b) {
  return squares_by_band(sequence, {a, b}, [&](const Pixel& p, std::size_t) {
    return sequence.at(a, p.x, p.y) - sequence.at(b, p.x, p.y);
  });
}

}  // namespace

std::optional<WrongFrame> find_wrong_frame(const Sequence& sequence,
                                           const std::vector<std::optional<Sequence::Gain>>& gains) {
  constexpr double kMinSquare = 0.006;  // stripes of 15 % contrast, of which half the pixels are wrong
  constexpr double kMinSquareOfCoarse =
      0.15;                        // where stripes are wide, a wrong one is wrong by the whole contrast
  constexpr double kFarAbove = 4;  // twice the amplitude
  std::vector<double> usual;
  for (const auto& gain : gains)
    if (gain) usual.push_back(gain->all);
  const double usual_gain = usual.empty() ? 1 : median_or(usual, 0.0);
  std::vector<Bands> sums;
  for (int k = 0; k < sequence.pairs(); ++k) {
    const auto& gain = gains[std::size_t(k)];
    sums.push_back(squares_by_band(sequence, sequence.pair(k), [&](const Pixel& p, std::size_t band) {
      // A wrong frame changes the brightness of its rows by half or all of the contrast: not a flicker.
      constexpr double kMaxFlicker = 0.25;
      const double factor =
          gain ? std::clamp(gain->band[band], usual_gain - kMaxFlicker, usual_gain + kMaxFlicker)
               : usual_gain;
      return sequence.sum(k, p.x, p.y) - factor * sequence.reference(p.x, p.y);
    }));
  }
  for (int k = 0; k < sequence.pairs(); ++k) {
    const Bands& sum = sums[std::size_t(k)];
    std::vector<std::size_t> wrong;
    const auto& gain = gains[std::size_t(k)];
    const double least_square = gain && gain->is_coarse ? kMinSquareOfCoarse : kMinSquare;
    for (std::size_t i = 0; i < kBands; ++i) {
      double beside = 0;
      if (k > 0) beside = sums[std::size_t(k - 1)][i];
      if (k + 1 < sequence.pairs()) beside = std::max(beside, sums[std::size_t(k + 1)][i]);
      if (sum[i] > std::max(least_square, kFarAbove * beside)) wrong.push_back(i);
    }
    if (wrong.size() < 2) continue;
    const FramePair& pair = sequence.pair(k);
    std::optional<WrongFrame> best;
    double least = 1e300;
    for (const auto& [capture, shows] :
         {FramePair{pair.second, pair.second - 1}, FramePair{pair.first, pair.first - 1},
          FramePair{pair.first, pair.first + 1}, FramePair{pair.second, pair.second + 1}}) {
      if (shows < 0 || shows >= sequence.captures()) continue;
      const Bands like = alike(sequence, capture, shows);
      std::size_t explained = 0;
      double total = 0;
      std::vector<double> wrong_sums;
      for (const std::size_t i : wrong) {
        explained += kFarAbove * like[i] < sum[i];
        total += like[i];
        wrong_sums.push_back(sum[i]);
      }
      // The border between two frames crosses a band or two.
      if (explained < 2 || explained + 2 < wrong.size() || 3 * explained < 2 * wrong.size()) continue;
      if (total >= least) continue;
      const double limit = median_or(wrong_sums, 0.0) / kFarAbove;
      const auto known = std::count_if(like.begin(), like.end(), [](double l) { return l >= 0; });
      const auto unlike = std::count_if(like.begin(), like.end(), [&](double l) { return l >= limit; });
      const bool everywhere = 8 * unlike <= known;  // few rows at the rim of the light may be noise
      least = total;
      best = WrongFrame{capture, shows, !everywhere, k};
    }
    if (best) return best;
  }
  return std::nullopt;
}

EndFault end_fault(const Sequence& sequence) {
  const int white = sequence.captures() - 2, black = sequence.captures() - 1;
  constexpr double kMinLight = 0.02;  // share of the image that the projector lights
  constexpr int kGrey = 20;
  const FramePair& coarse = sequence.pair(0);
  const double lit = sequence.differing(coarse.first, coarse.second, kGrey);
  if (lit < kMinLight) return EndFault::kNone;
  const bool alike = sequence.differing(white, black, kGrey) < 0.05 * lit;
  double squares = 0, contrasts = 0;
  std::vector<double> blacks;
  std::size_t bright = 0;
  for (int y = 4; y < sequence.size().height; y += 8)
    for (int x = 4; x < sequence.size().width; x += 8) {
      const double a = sequence.at(coarse.first, x, y), b = sequence.at(coarse.second, x, y);
      const double w = sequence.at(white, x, y), k = sequence.at(black, x, y);
      if (std::abs(a - b) < kGrey) continue;
      const double contrast = std::max(a, b) - k, d = w - sequence.at(white - 1, x, y);
      squares += d * d, contrasts += contrast * contrast;
      blacks.push_back((std::min(a, b) - k) / std::max(contrast, 1.0));
      bright += 2 * w > a + b;
    }
  if (alike) return 2 * bright > blacks.size() ? EndFault::kStaleBlack : EndFault::kNoWhite;
  // White that shows the finest stripes is equal to the capture before, and darker than coarse white stripes,
  // while black is right: a camera whose exposure follows the light makes black brighter than black stripes.
  constexpr double kAlike = 0.04, kMaxDarker = 0.03;
  return squares < kAlike * contrasts && median_or(std::move(blacks), 0.0) > -kMaxDarker
             ? EndFault::kStaleWhite
             : EndFault::kNone;
}

}  // namespace procam::pattern::internal
