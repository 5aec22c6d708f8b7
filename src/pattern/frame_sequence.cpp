#include "procam/pattern/frame_sequence.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "exchanged_steps.hpp"
#include "gray_code_bits.hpp"
#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"
#include "waves.hpp"

namespace procam::pattern {
namespace {

using Kind = SequenceFrame::Kind;

constexpr double kSamePeriod = 1e-6;  // relative

const char* const kAxisNames[2] = {"columns", "rows"};

[[noreturn]] void refuse(const std::string& why, const std::string& next) {
  throw Error(ErrorKind::kInput, "frame sequence", why, next);
}

int index_of(StripeAxis axis) {
  return axis == StripeAxis::kColumn ? 0 : 1;
}

std::string number_text(double value) {
  return format("%.6g", value);
}

/// Gray code over the frame and the offsets before it: its codes count from 0.
GrayCode gray_code_of(const FrameSequence& sequence, ImageSize projector_size) {
  return {{projector_size.width + sequence.offset[0] * sequence.step,
           projector_size.height + sequence.offset[1] * sequence.step},
          sequence.step};
}

/// Numbers of the frames that show a bit and its inverse, by significance; -1: absent.
struct BitFrames {
  int pattern = -1, inverse = -1;
};

struct GrayFrames {
  std::vector<BitFrames> bits[2];
  int white = -1, black = -1;
  bool has_inverse = false;
};

GrayFrames gray_frames_of(const FrameSequence& sequence) {
  GrayFrames found;
  const auto set = [&](int& place, int frame, const std::string& what) {
    if (place >= 0)
      refuse("frames " + std::to_string(place) + " and " + std::to_string(frame) + " are both " + what,
             "describe a second capture of the same as \"ignore\"");
    place = frame;
  };
  for (int i = 0; i < int(sequence.frames.size()); ++i) {
    const SequenceFrame& frame = sequence.frames[std::size_t(i)];
    if (frame.kind == Kind::kWhite) set(found.white, i, "white");
    if (frame.kind == Kind::kBlack) set(found.black, i, "black");
    if (frame.kind != Kind::kGray) continue;
    const int axis = index_of(frame.axis);
    std::vector<BitFrames>& bits = found.bits[axis];
    if (frame.bit < 0 || frame.bit > 15)
      refuse("frame " + std::to_string(i) + " has bit " + std::to_string(frame.bit),
             "give the significance of the bit, 0 for the finest");
    if (int(bits.size()) <= frame.bit) bits.resize(std::size_t(frame.bit) + 1);
    BitFrames& bit = bits[std::size_t(frame.bit)];
    set(frame.inverse ? bit.inverse : bit.pattern, i,
        std::string(kAxisNames[axis]) + " bit " + std::to_string(frame.bit) +
            (frame.inverse ? ", inverse" : ""));
    found.has_inverse = found.has_inverse || frame.inverse;
  }
  return found;
}

/// The waves of one axis, finest first.
AxisWaves waves_of(const FrameSequence& sequence, ImageSize projector_size, StripeAxis axis) {
  struct Steps {
    double period = 0;
    std::vector<std::pair<double, int>> by_phase;  ///< in [0, 2 pi), frame
  };
  std::vector<Steps> all;
  for (int i = 0; i < int(sequence.frames.size()); ++i) {
    const SequenceFrame& frame = sequence.frames[std::size_t(i)];
    if (frame.kind != Kind::kPhase || frame.axis != axis) continue;
    if (!(frame.period >= 2))
      refuse("frame " + std::to_string(i) + " has a period of " + number_text(frame.period) + " pixels",
             "give the length of the wave in projector pixels, 2 or more");
    auto same = std::find_if(all.begin(), all.end(), [&](const Steps& steps) {
      return std::abs(steps.period - frame.period) < kSamePeriod * frame.period;
    });
    if (same == all.end()) same = all.insert(all.end(), Steps{frame.period, {}});
    const double turns = frame.phase / kTau;
    same->by_phase.emplace_back(kTau * (turns - std::floor(turns)), i);
  }
  std::sort(all.begin(), all.end(), [](const Steps& a, const Steps& b) { return a.period < b.period; });
  AxisWaves waves;
  waves.axis = axis;
  waves.size = axis == StripeAxis::kColumn ? projector_size.width : projector_size.height;
  for (Steps& steps : all) {
    std::stable_sort(steps.by_phase.begin(), steps.by_phase.end());
    std::vector<int> frames;
    std::vector<double> phases;
    for (const auto& [phase, frame] : steps.by_phase) phases.push_back(phase), frames.push_back(frame);
    const std::optional<Wave> wave = fit_wave(steps.period, frames, phases);
    if (!wave)
      refuse("the " + std::to_string(frames.size()) + " phases of the " + kAxisNames[index_of(axis)] +
                 "' wave of " + number_text(steps.period) + " pixels do not determine it",
             "a wave needs three or more phases, spread over the circle");
    waves.waves.push_back(*wave);
  }
  return waves;
}

void require_gray_axis(const GrayFrames& found, const GrayCode& gray_code, int axis) {
  const StripeAxis stripes = axis == 0 ? StripeAxis::kColumn : StripeAxis::kRow;
  for (int bit = 0; bit < bit_count(gray_code, stripes); ++bit) {
    const auto& bits = found.bits[axis];
    if (bit < int(bits.size()) &&
        (bits[std::size_t(bit)].pattern >= 0 || bits[std::size_t(bit)].inverse >= 0))
      continue;
    refuse("bit " + std::to_string(bit) + " of the " + kAxisNames[axis] +
               " is missing: " + std::to_string(stripe_count(gray_code, stripes)) + " stripes have " +
               std::to_string(bit_count(gray_code, stripes)) + " bits",
           "describe every bit, 0 the finest, or give the width of the finest stripes as \"step\"");
  }
}

void require_threshold(const GrayFrames& found) {
  for (int axis = 0; axis < 2; ++axis)
    for (const BitFrames& bit : found.bits[axis])
      if ((bit.pattern < 0) != (bit.inverse < 0) && found.white < 0 && !found.has_inverse)
        refuse("it has neither inverse frames nor a white one, so no threshold separates light from dark",
               "capture white and black, or the inverse of each frame, as well");
}

void require_number_of_wave(const AxisWaves& axis, const GrayFrames& gray, const GrayCode& gray_code, int a) {
  const std::string name = kAxisNames[a];
  const double coarsest = axis.waves.back().period;
  if (!gray.bits[a].empty()) {
    require_gray_axis(gray, gray_code, a);
    if (gray_code.step > coarsest)
      refuse("its Gray-code stripes of " + std::to_string(gray_code.step) + " pixels are wider than the " +
                 name + "' wave of " + number_text(coarsest),
             "stripes of one wave or less number the waves");
    return;
  }
  if (axis.spans_frame()) return;
  const double range = unambiguous_range(axis);
  if (range < axis.size)
    refuse("the " + name + "' waves have the same phases again after " + number_text(range) +
               " pixels, the frame has " + std::to_string(axis.size),
           "add Gray code, or a wave that spans the frame, or waves of other lengths");
}

bool has_waves(const FrameSequence& sequence) {
  return std::any_of(sequence.frames.begin(), sequence.frames.end(),
                     [](const SequenceFrame& frame) { return frame.kind == Kind::kPhase; });
}

void check_captures(const std::vector<ViewU8>& captures, const FrameSequence& sequence) {
  const auto fail = [](const std::string& why) {
    throw Error(ErrorKind::kInput, "captures", why, "check the description of the pattern and the frames");
  };
  if (captures.size() != sequence.frames.size())
    fail(std::to_string(captures.size()) + " frames where the pattern has " +
         std::to_string(sequence.frames.size()));
  for (std::size_t i = 0; i < captures.size(); ++i)
    if (captures[i].empty() || captures[i].channels != 1 || captures[i].size() != captures[0].size())
      fail("frame " + std::to_string(i) + " is empty, has several channels or another size than frame 0");
}

/// Each wave against the position that the longer one gives, the longest against Gray code; where these number the waves
/// alone, in stripes of more than half a wave, it has no phase to agree with. `shortest`: of the longest wave then.
void check_agreement(const AxisWaves& axis, double shortest, const WaveCounts& counts, Diagnostics& found) {
  constexpr long kFew = 500;
  // Described as shown: 0.66 to 0.94 and within 0.02 turns, with noise, tone curves and light between surfaces.
  constexpr double kShort = 0.4, kFarTurns = 0.12;
  for (std::size_t w = 0; w < counts.agreement.size(); ++w) {
    const WaveAgreement& agreement = counts.agreement[w];
    const bool is_longest = w + 1 == counts.agreement.size();
    if (agreement.count < kFew || (is_longest && axis.waves[w].period < shortest)) continue;
    const bool scatters = agreement.length() < kShort;
    if (!scatters && std::abs(agreement.turns()) < kFarTurns) continue;
    const std::string name = std::string(kAxisNames[index_of(axis.axis)]) + "' wave of " +
                             number_text(axis.waves[w].period) + " pixels";
    const std::string other = is_longest ? "the Gray code" : "the longer wave";
    found.warn(
        "waves_disagree",
        "The " + name + " does not fit " + other +
            (scatters ? ": the difference is another one at each pixel; a period, the order of the frames or "
                        "the sign of a phase is another than described"
                      : ", by " + format("%.2f", std::abs(agreement.turns())) +
                            " of a wave at all pixels alike; a phase is another than described (a sine is 90 "
                            "degrees behind a cosine), or a period") +
            "; capture this view again where others fit, else compare the description with the frames that were shown "
            "(make-patterns --pattern writes those of a description)");
    return;
  }
}

/// False where captures were exchanged: nothing can be decoded then.
bool steps_are_in_order(const std::vector<ViewU8>& captures, const std::vector<AxisWaves>& axes,
                        const PhaseOptions& options, Diagnostics& found) {
  const auto exchanged = internal::find_exchanged_steps(captures, axes, options);
  if (exchanged.empty()) return true;
  std::string which;
  for (const auto& [first, second] : exchanged)
    which += (which.empty() ? "frame " : ", or frame ") + std::to_string(first) + " and frame " +
             std::to_string(second);
  found.warn("frames_exchanged",
             "The captures of " + which + (exchanged.size() > 1 ? "," : "") +
                 " are exchanged: put the files back into their order, or capture this view again");
  return false;
}

template <typename Level>
ImageU8 image_of(ImageSize size, Level level) {
  ImageU8 image(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) image.at(x, y) = level(x, y);
  return image;
}

ImageU8 frame_of(const SequenceFrame& frame, const FrameSequence& sequence, ImageSize size) {
  if (frame.kind == Kind::kWhite) return ImageU8(size, 1, 255);
  if (frame.kind == Kind::kBlack || frame.kind == Kind::kIgnored) return ImageU8(size, 1, 0);
  const int axis = index_of(frame.axis);
  std::vector<std::uint8_t> levels;
  for (int i = 0; i < (axis == 0 ? size.width : size.height); ++i) {
    if (frame.kind == Kind::kGray) {
      const unsigned code = unsigned(i / sequence.step + sequence.offset[std::size_t(axis)]);
      const bool is_lit = (((code ^ (code >> 1)) >> frame.bit) & 1u) != 0;
      levels.push_back(is_lit != frame.inverse ? 255 : 0);
    } else {
      levels.push_back(
          std::uint8_t(std::lround(127.5 * (1 + std::cos(kTau * i / frame.period - frame.phase)))));
    }
  }
  return image_of(size, [&](int x, int y) { return levels[std::size_t(axis == 0 ? x : y)]; });
}

/// The median of the brighter (darker) frame of each pair, where there are pairs: fine bits that blur makes
/// grey do not count then. Else the extreme of all Gray-code frames.
ImageU8 end_of(const std::vector<ViewU8>& captures, const GrayFrames& found, bool bright) {
  std::vector<BitFrames> pairs;
  std::vector<int> all;
  for (const auto& axis : found.bits)
    for (const BitFrames& bit : axis) {
      if (bit.pattern >= 0 && bit.inverse >= 0) pairs.push_back(bit);
      for (const int frame : {bit.pattern, bit.inverse})
        if (frame >= 0) all.push_back(frame);
    }
  std::vector<std::uint8_t> values;
  return image_of(captures[0].size(), [&](int x, int y) {
    const auto at = [&](int frame) { return captures[std::size_t(frame)].at(x, y); };
    values.clear();
    for (const BitFrames& pair : pairs)
      values.push_back(bright ? std::max(at(pair.pattern), at(pair.inverse))
                              : std::min(at(pair.pattern), at(pair.inverse)));
    if (pairs.empty())
      for (const int frame : all) values.push_back(at(frame));
    return at_rank(values, pairs.empty() ? (bright ? values.size() - 1 : 0) : values.size() / 2);
  });
}

/// White A + B and black A - B by a wave of the sequence, the longest: blur takes least of it.
ImageU8 end_of_wave(const std::vector<ViewU8>& captures, const Wave& wave, bool bright) {
  ImageU8 image(captures[0].size());
  std::vector<float> mean, modulation;
  for (int y = 0; y < image.height(); ++y) {
    flat_light_of(captures, wave, y, mean, modulation);
    for (int x = 0; x < image.width(); ++x) {
      const float b = bright ? modulation[std::size_t(x)] : -modulation[std::size_t(x)];
      image.at(x, y) = std::uint8_t(std::clamp(mean[std::size_t(x)] + b + 0.5f, 0.f, 255.f));
    }
  }
  return image;
}

}  // namespace

bool is_gray_code(const FrameSequence& sequence) {
  return !has_waves(sequence);
}

void require_decodable(const FrameSequence& sequence, ImageSize projector_size) {
  if (sequence.step < 1) refuse("its step is below 1", "give the width of the finest stripes in pixels");
  for (int a = 0; a < 2; ++a)
    if (sequence.offset[std::size_t(a)] < 0 || sequence.offset[std::size_t(a)] > 32767)
      refuse("an offset is outside 0..32767", "give what the Gray code adds to the number of a stripe");
  const GrayFrames gray = gray_frames_of(sequence);
  const GrayCode gray_code = gray_code_of(sequence, projector_size);
  if (!has_waves(sequence)) {
    for (int a = 0; a < 2; ++a) require_gray_axis(gray, gray_code, a);
    require_threshold(gray);
    return;
  }
  if (gray.bits[0].empty() != gray.bits[1].empty())
    refuse(std::string("its Gray code is of ") + kAxisNames[gray.bits[0].empty() ? 1 : 0] + " alone",
           "describe the Gray code of both axes, or none");
  for (const StripeAxis axis : {StripeAxis::kColumn, StripeAxis::kRow}) {
    const AxisWaves waves = waves_of(sequence, projector_size, axis);
    if (waves.waves.empty())
      refuse(std::string("it has no waves of ") + kAxisNames[index_of(axis)] + ", but of the other axis",
             "describe phase steps, or Gray code, of both axes");
    require_number_of_wave(waves, gray, gray_code, index_of(axis));
  }
}

std::vector<ImageU8> frames(const FrameSequence& sequence, ImageSize projector_size) {
  std::vector<ImageU8> all;
  for (const SequenceFrame& frame : sequence.frames) all.push_back(frame_of(frame, sequence, projector_size));
  return all;
}

std::string describe(const FrameSequence& sequence, ImageSize projector_size) {
  const auto count = [&](Kind kind) {
    return std::count_if(sequence.frames.begin(), sequence.frames.end(),
                         [&](const SequenceFrame& frame) { return frame.kind == kind; });
  };
  const long gray = count(Kind::kGray), phase = count(Kind::kPhase);
  return std::to_string(sequence.frames.size()) + " frames for " + std::to_string(projector_size.width) +
         "x" + std::to_string(projector_size.height) + " (" + std::to_string(gray) + " Gray code, " +
         std::to_string(phase) + " phase, " + std::to_string(long(sequence.frames.size()) - gray - phase) +
         " other)";
}

GrayCaptures gray_captures(const std::vector<ViewU8>& captures, const FrameSequence& sequence,
                           ImageSize projector_size) {
  check_captures(captures, sequence);
  const GrayFrames found = gray_frames_of(sequence);
  GrayCaptures ordered;
  ordered.gray_code = gray_code_of(sequence, projector_size);
  for (int a = 0; a < 2; ++a) require_gray_axis(found, ordered.gray_code, a);
  ordered.has_all_inverses = true;
  ordered.replaced.reserve(sequence.frames.size() + 2);  // views into it stay
  const auto append = [&](int frame) {
    ordered.captures.push_back(captures[std::size_t(frame)]);
    ordered.original.push_back(frame);
  };
  const auto append_replaced = [&](ImageU8 image) {
    ordered.replaced.push_back(std::move(image));
    ordered.captures.emplace_back(ordered.replaced.back());
    ordered.original.push_back(-1);
  };

  std::optional<Wave> wave;
  for (const StripeAxis axis : {StripeAxis::kColumn, StripeAxis::kRow})
    if (const AxisWaves waves = waves_of(sequence, projector_size, axis); !waves.waves.empty())
      if (!wave || waves.waves.back().period > wave->period) wave = waves.waves.back();
  const auto end = [&](int frame, bool bright) {
    if (frame >= 0) return captures[std::size_t(frame)];
    if (!wave) require_threshold(found);
    ordered.replaced.push_back(wave && !found.has_inverse ? end_of_wave(captures, *wave, bright)
                                                          : end_of(captures, found, bright));
    return ViewU8(ordered.replaced.back());
  };
  const ViewU8 white = end(found.white, true), black = end(found.black, false);
  for (int a = 0; a < 2; ++a)
    for (int bit = bit_count(ordered.gray_code, a == 0 ? StripeAxis::kColumn : StripeAxis::kRow);
         bit-- > 0;) {
      const BitFrames& shown = found.bits[a][std::size_t(bit)];
      const auto other = [&](int frame) {
        ordered.has_all_inverses = false;
        const ViewU8& there = captures[std::size_t(frame)];
        return image_of(there.size(), [&](int x, int y) {
          return std::uint8_t(std::clamp(white.at(x, y) + black.at(x, y) - there.at(x, y), 0, 255));
        });
      };
      shown.pattern >= 0 ? append(shown.pattern) : append_replaced(other(shown.inverse));
      shown.inverse >= 0 ? append(shown.inverse) : append_replaced(other(shown.pattern));
    }
  ordered.captures.push_back(white), ordered.original.push_back(found.white);
  ordered.captures.push_back(black), ordered.original.push_back(found.black);
  return ordered;
}

LightMap decode(const std::vector<ViewU8>& captures, const FrameSequence& sequence, ImageSize projector_size,
                const PhaseOptions& options) {
  require(options.min_modulation > 0 && options.max_sigma_px > 0 && options.wave_sigmas > 0,
          "decode: an option of PhaseOptions is not positive");
  require(has_waves(sequence), "decode: the sequence has no waves");
  require_decodable(sequence, projector_size);
  check_captures(captures, sequence);
  const std::vector<AxisWaves> axes = {waves_of(sequence, projector_size, StripeAxis::kColumn),
                                       waves_of(sequence, projector_size, StripeAxis::kRow)};
  LightMap map;
  map.projector_size = projector_size;
  map.period = axes[0].waves.front().period;
  map.pixel = ImageF(captures[0].size(), 2);
  map.sigma = ImageF(captures[0].size(), 2);
  if (!steps_are_in_order(captures, axes, options, map.diagnostics)) return map;
  const NoiseModel noise = noise_of_waves(captures, axes[0].waves.front());
  const GrayFrames gray = gray_frames_of(sequence);
  std::optional<DecodedMap> codes;
  if (!gray.bits[0].empty() && !gray.bits[1].empty()) {
    const GrayCaptures ordered = gray_captures(captures, sequence, projector_size);
    codes = decode(ordered.captures, ordered.gray_code);
    for (int a = 0; a < 2; ++a) {
      Image<std::int16_t>& image = a == 0 ? codes->columns : codes->rows;
      for (std::int16_t* code = image.data(); code != image.data() + image.width() * image.height(); ++code)
        if (*code >= 0) *code = std::int16_t(std::max(*code - sequence.offset[std::size_t(a)], -1));
    }
    map.diagnostics.append(codes->diagnostics);
  }
  WaveCounts counts;
  for (const AxisWaves& axis : axes) {
    const Image<std::int16_t>* const gray_codes = !codes                             ? nullptr
                                                  : axis.axis == StripeAxis::kColumn ? &codes->columns
                                                                                     : &codes->rows;
    const WaveCounts seen = decode_waves(captures, axis, {gray_codes, sequence.step}, noise, options, map);
    counts.lit += seen.lit;
    counts.saturated += seen.saturated;
    counts.decoded += seen.decoded;
    if (axis.spans_frame() || gray_codes != nullptr)
      check_agreement(axis, gray_codes != nullptr ? 2 * sequence.step : 0, seen, map.diagnostics);
  }
  const auto percent = [](long part, long all) { return std::to_string(100 * part / std::max(1L, all)); };
  const long pixels = 2L * map.camera_size().width * map.camera_size().height;
  if (counts.saturated > counts.lit / 100)
    map.diagnostics.warn("saturated", percent(counts.saturated, counts.lit) +
                                          " % of the lit pixels are saturated and rejected; expose shorter");
  if (counts.decoded < pixels / 100)
    map.diagnostics.warn("low_modulation",
                         "only " + percent(counts.decoded, pixels) +
                             " % of the pixels decode; expose longer, or use longer waves (they should span "
                             "five camera pixels or more)");
  return map;
}

ImageU8 flat_light(const std::vector<ViewU8>& captures, const FrameSequence& sequence,
                   ImageSize projector_size) {
  check_captures(captures, sequence);
  require(!captures.empty(), "flat_light: no captures");
  std::vector<Wave> waves;
  for (const StripeAxis axis : {StripeAxis::kColumn, StripeAxis::kRow})
    for (Wave& wave : waves_of(sequence, projector_size, axis).waves) waves.push_back(std::move(wave));
  ImageU8 flat(captures[0].size());
  std::vector<float> mean, modulation;
  for (int y = 0; y < flat.height(); ++y) {
    std::vector<float> sum(std::size_t(flat.width()), 0.f);
    float frames = 0;
    for (const Wave& wave : waves) {
      flat_light_of(captures, wave, y, mean, modulation);
      const float weight = float(wave.frames.size());
      frames += weight;
      for (std::size_t x = 0; x < sum.size(); ++x) sum[x] += weight * mean[x];
    }
    for (std::size_t x = 0; x < sum.size(); ++x)
      flat.row(y)[x] = std::uint8_t(std::clamp(sum[x] / frames + 0.5f, 0.f, 255.f));
  }
  return flat;
}

}  // namespace procam::pattern
