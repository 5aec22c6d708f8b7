#include "procam/pattern/phase_shift.hpp"

#include <algorithm>
#include <cmath>

#include "gray_code_bits.hpp"
#include "waves.hpp"

namespace procam::pattern {
namespace {

constexpr int kFineSteps = 8, kCoarseSteps = 4;
constexpr double kRoom = 1.125;       // longest wave, in frames: its ends are not taken for each other
constexpr double kLargestRatio = 12;  // of a wave to the next finer one

/// Periods of an axis of `size` pixels, finest first.
std::vector<double> periods(const PhaseShift& shown, int size) {
  std::vector<double> all{double(shown.period)};
  if (shown.wave_number == WaveNumber::kGrayCode) return all;
  const double longest = kRoom * size, whole = longest / shown.period;
  const int coarser = std::max(1, int(std::ceil(std::log(whole) / std::log(kLargestRatio) - 1e-9)));
  for (int i = 1; i <= coarser; ++i) all.push_back(shown.period * std::pow(whole, double(i) / coarser));
  return all;
}

}  // namespace

FrameSequence sequence(const PhaseShift& shown) {
  const ImageSize size = shown.projector_size;
  require(size.width >= 1 && size.height >= 1 && size.width <= 32767 && size.height <= 32767,
          "PhaseShift: projector size outside 1..32767");
  require(
      shown.period >= 4 && shown.period % 2 == 0 && shown.period <= std::min(size.width, size.height),
      "PhaseShift: period " + std::to_string(shown.period) + " is odd, below 4, or longer than the frame");
  const bool gray = shown.wave_number == WaveNumber::kGrayCode;
  FrameSequence all;
  for (const StripeAxis axis : {StripeAxis::kColumn, StripeAxis::kRow}) {
    const int pixels = axis == StripeAxis::kColumn ? size.width : size.height;
    // Waves begin where the longest one's unused part ends.
    const double margin = gray ? 0 : 0.5 * (kRoom - 1) * pixels;
    for (const double period : periods(shown, pixels)) {
      const int steps = period == shown.period ? kFineSteps : kCoarseSteps;
      for (int k = 0; k < steps; ++k)
        all.frames.push_back({SequenceFrame::Kind::kPhase, axis, 0, false, period,
                              kTau * (double(k) / steps - margin / period)});
    }
  }
  if (!gray) return all;
  all.step = shown.period / 2;
  const GrayCode gray_code{size, all.step};
  for (int i = 0; i < frame_count(gray_code); ++i) {
    const GrayCodeFrame info = frame_info(gray_code, i);
    SequenceFrame& frame = all.frames.emplace_back();
    frame.axis = info.kind == GrayCodeFrame::Kind::kRowBit ? StripeAxis::kRow : StripeAxis::kColumn;
    frame.bit = info.bit;
    frame.inverse = info.inverse;
    frame.kind = info.kind == GrayCodeFrame::Kind::kWhite   ? SequenceFrame::Kind::kWhite
                 : info.kind == GrayCodeFrame::Kind::kBlack ? SequenceFrame::Kind::kBlack
                                                            : SequenceFrame::Kind::kGray;
  }
  return all;
}

int frame_count(const PhaseShift& shown) {
  return int(sequence(shown).frames.size());
}

std::vector<ImageU8> frames(const PhaseShift& shown) {
  return frames(sequence(shown), shown.projector_size);
}

std::string describe(const PhaseShift& shown) {
  const ImageSize size = shown.projector_size;
  const std::string text = std::to_string(frame_count(shown)) + " frames for " + std::to_string(size.width) +
                           "x" + std::to_string(size.height) + " (" + std::to_string(kFineSteps) +
                           " steps of " + std::to_string(shown.period) + " px waves, ";
  if (shown.wave_number == WaveNumber::kGrayCode)
    return text + "Gray code in steps of " + std::to_string(shown.period / 2) + " px)";
  return text + std::to_string(kCoarseSteps) + " steps each of " +
         std::to_string(periods(shown, size.width).size() - 1) + " coarser waves)";
}

LightMap decode(const std::vector<ViewU8>& captures, const PhaseShift& shown, const PhaseOptions& options) {
  return decode(captures, sequence(shown), shown.projector_size, options);
}

ImageU8 flat_light(const std::vector<ViewU8>& captures, const PhaseShift& shown) {
  return flat_light(captures, sequence(shown), shown.projector_size);
}

}  // namespace procam::pattern
