#include "sequence_causes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

#include "exchanged_frames.hpp"
#include "procam/core/base/stats.hpp"
#include "sequence_motion.hpp"
#include "stripe_motion.hpp"
#include "wrong_frame.hpp"

namespace procam::pattern::internal {
namespace {

constexpr std::size_t kFewLit = 200;
constexpr double kMotionPx = 0.25;  // below, stripe edges of other pairs err by as much
constexpr double kNoisy = 0.12;  // a bit is then read wrong in one pixel of a thousand at half the contrast
constexpr double kStripeMotionPx = 0.3;  // projector pixels: a third of the finest stripe
constexpr double kScattered = 0.1;       // white walls and a clean lens scatter half of it
constexpr double kClipped = 0.1;         // of the lit pixels
constexpr double kUnsteady = 0.025;  // of the brightness: stripe edges then move by a fortieth of their width
constexpr double kExposure = 0.03, kDarker = 0.02;  // of white, of the contrast
constexpr double kLag = 0.03;                // of white: a wave then moves by 0.3 to 0.5 % of its length
constexpr double kByNoise = 0.2;             // of its share of the contrast
constexpr double kUnsteadyOfShaking = 0.06;  // where stripes move, the print's shades mix with them

std::string format(const char* pattern, double value) {
  char text[64];
  std::snprintf(text, sizeof text, pattern, value);
  return text;
}

using Gains = std::vector<std::optional<Sequence::Gain>>;

void warn_exposure(double change, Diagnostics& found) {
  found.warn("exposure_changes",
             "Frames of half light are " + format("%.0f %%", 100 * change) +
                 " brighter by the white and black frames than they should be: the "
                 "camera's exposure follows the light, each image's contrast is "
                 "stretched, or the projector's lamp follows the frame; fix exposure, gain "
                 "and white balance, save images without automatic contrast, and switch "
                 "the projector's dynamic contrast (automatic iris) off");
}

void warn_stretched(double change, Diagnostics& found) {
  found.warn("exposure_changes",
             "Every image spans all grey levels, and brightness changes by " +
                 format("%.0f %%", 100 * change) +
                 ": each image's contrast is stretched; save images without automatic contrast, and fix "
                 "exposure, gain and white balance");
}

/// Where the dark stripes change as much as the bright ones do, the room's light changes.
bool by_lamps(const std::array<double, 2>& unsteadiness) {
  constexpr double kByLamps = 0.35;
  const auto [dark, bright] = unsteadiness;
  return dark > kByLamps * bright;
}

/// So much that pairs do not complement each other; no wrong frame makes dark stripes of one place differ.
bool lamps_flicker_strongly(const Sequence& sequence) {
  constexpr double kStrong = 0.08;  // of the contrast
  const std::array<double, 2> unsteadiness = sequence.unsteadiness();
  return unsteadiness[0] > kStrong && by_lamps(unsteadiness);
}

void warn_flicker(const Sequence& sequence, double change, Diagnostics& found) {
  const std::string text =
      "Brightness changes by " + format("%.0f %%", 100 * change) + " from frame to frame or over the rows: ";
  if (by_lamps(sequence.unsteadiness()))
    found.warn("flicker",
               text +
                   "the room's lamps flicker, as dark stripes change too; switch the lamps off, or set the "
                   "exposure to a multiple of half the mains period (10 ms at 50 Hz, 8.33 ms at 60 Hz)");
  else
    found.warn("flicker",
               text +
                   "lamps or projector flicker, or the camera adjusts each image's contrast; set the "
                   "exposure to a multiple of their period (mains: 20 ms or 16.7 ms), and switch automatic "
                   "contrast off");
}

/// "exposure_changes": all frames are half white, so their brightness by white and black is the same; and it
/// is not one, or black is brighter than black stripes; or it differs from frame to frame, and every image spans all
/// grey levels. "flicker": it differs, and they do not; or it differs over the rows.
void check_brightness(const Sequence& sequence, const Gains& gains, bool shakes, SequenceCheck& check) {
  std::vector<const Sequence::Gain*> coarse;
  for (const auto& gain : gains)
    if (gain && gain->is_coarse) coarse.push_back(&*gain);
  const double darker = -sequence.black_stripes();
  if (coarse.size() < 4) {
    if (darker > 5 * kDarker) warn_exposure(darker, check.diagnostics);
    return;
  }
  std::vector<double> sums, off, steps, ripples;
  std::array<double, kBands> usual_band{};
  for (const Sequence::Gain* gain : coarse) {
    sums.push_back(gain->all);
    if (gain->first) steps.push_back(std::abs(*gain->first - *gain->second));
  }
  const double usual = median_or(sums, 0.0);
  for (const double sum : sums) off.push_back(std::abs(sum / usual - 1));
  for (std::size_t i = 0; i < kBands; ++i) {
    std::vector<double> of_band;
    for (const Sequence::Gain* gain : coarse)
      if (gain->error[i] > 0) of_band.push_back(gain->band[i] / gain->all);
    usual_band[i] = median_or(std::move(of_band), 0.0);
  }
  for (const Sequence::Gain* gain : coarse) {
    double squares = 0, noise = 0;
    int bands = 0;
    for (std::size_t i = 0; i < kBands; ++i)
      if (gain->error[i] > 0) {
        squares += std::pow(gain->band[i] / gain->all - usual_band[i], 2);
        noise += std::pow(gain->error[i] / gain->all, 2);
        ++bands;
      }
    if (bands >= 3) ripples.push_back(std::sqrt(std::max(0.0, squares - noise) / bands));
  }
  // Of a frame: the sum averages two, the difference of two has twice the variance of one.
  const double spread =
      1.4826 * std::max(std::sqrt(2.0) * median_or(off, 0.0), median_or(steps, 0.0) / std::sqrt(2.0));
  const double ripple = median_or(ripples, 0.0);
  std::vector<double> known_bands;
  for (const double of_band : usual_band)
    if (of_band > 0) known_bands.push_back(std::abs(of_band - 1));
  const double uneven = median_or(std::move(known_bands), 0.0);  // white and black themselves flicker
  const double change = std::max(std::abs(usual - 1), darker);
  // Noise shifts ratios: their numerator and denominator have it.
  const double by_noise = kByNoise * check.noise;
  const bool follows = std::abs(usual - 1) > kExposure + by_noise || darker > kDarker + by_noise;
  // An exposure is one number a frame, and the same over the rows.
  constexpr double kSteady = 0.5, kEven = 0.3;
  if (follows && spread < kSteady * change && std::max(ripple, uneven) < kEven * change) {
    warn_exposure(change, check.diagnostics);
    return;
  }
  const double unsteady = std::max(spread, ripple);
  if (unsteady <= (shakes ? kUnsteadyOfShaking : kUnsteady) + by_noise) return;
  if (sequence.spans_all_greys())
    warn_stretched(unsteady, check.diagnostics);
  else
    warn_flicker(sequence, unsteady, check.diagnostics);
}

/// Of the print, as long as the projected frames are in order.
struct Motion {
  std::vector<double> gains;  ///< of each pair, 1 where unknown
  Series print;
  std::vector<EdgePixel> background_edges;

  /// The print rests after a step that no light can feign: by more than a pixel, in several pairs alike.
  bool has_clear_step() const {
    constexpr double kClearPx = 1;
    constexpr std::ptrdiff_t kMovedPairs = 2, kRestingPairs = 3;
    if (!print.known()) return false;
    const Points3 all = print.motion();
    int at = 0;
    if (!(print.largest() > kClearPx) || course(print, at) != Course::kStep) return false;
    const auto after =
        all.begin() + (std::lower_bound(print.pair.begin(), print.pair.end(), at) - print.pair.begin());
    const auto rests = [](const Vec3& m) { return m.norm() < kMotionPx; };
    const auto moved = std::count_if(all.begin(), after, [&](const Vec3& m) { return m.norm() > kClearPx; });
    // The step may lie within the first pair after it.
    return moved >= kMovedPairs && std::count_if(after, all.end(), rests) >= kRestingPairs &&
           std::all_of(after + 1, all.end(), rests);
  }

  /// In most pairs, each its own way.
  bool shakes() const {
    int at = 0;
    std::size_t moving = 0;
    for (const Vec3& m : print.motion()) moving += m.norm() > kMotionPx;
    return print.known() && 2 * moving > print.size() && course(print, at) == Course::kShake;
  }
};

/// "board_moved", "camera_moved", "camera_drift" or "camera_shake".
void check_print(const Sequence& sequence, const Motion& motion, const FrameName& name,
                 SequenceCheck& check) {
  const Series& print = motion.print;
  int at = 0;
  const std::string by = format("%.1f px", print.largest());
  const Background behind = background(sequence, motion.background_edges, print, motion.gains);
  const Course kind = course(print, at);
  Diagnostics& found = check.diagnostics;
  if (kind == Course::kStep || behind == Background::kRests) {
    const bool board = behind != Background::kMoves;
    const std::string moved = behind == Background::kUnknown ? "The board, or the camera,"
                              : board                        ? "The board"
                                                             : "The camera";
    const int capture = at < sequence.pairs() ? sequence.pair(at).first : sequence.captures() - 2;
    found.warn(board ? "board_moved" : "camera_moved",
               moved + " moved by " + by +
                   (kind == Course::kStep ? " before the capture of " + name(capture) + ": the frames"
                                          : std::string(" during the sequence: the frames")) +
                   " before and after do not fit together; fix it, and capture this view again");
    check.decoding_is_wrong = true;
  } else if (kind == Course::kDrift) {
    found.warn("camera_drift",
               "The image of the board drifts by " + by +
                   " over the sequence: switch image stabilisation off and fix camera and board");
  } else {
    found.warn("camera_shake",
               "The image shakes by " + by +
                   " from frame to frame: put the camera on a tripod (and the board on a stand), and switch "
                   "image stabilisation off");
  }
}

/// A change over the whole sequence that no step between two pairs comes near to, and that goes on from pair to pair: of
/// light that is unevenly complementary the blur scatters.
bool focus_drifts(const Series& print) {
  std::vector<double> blur, steps;
  for (const PairFit& fit : print.fit) blur.push_back(fit.blur);
  for (std::size_t i = 1; i < blur.size(); ++i) steps.push_back(std::abs(blur[i] - blur[i - 1]));
  const auto [low, high] = std::minmax_element(blur.begin(), blur.end());
  if (!(*high - *low > 0.15 && *high - *low > 5 * median_or(steps, 0.0) &&
        std::abs(blur.front() - blur.back()) > 0.6 * (*high - *low)))
    return false;
  constexpr double kExplained =
      0.6;  // of the variance, by a straight line; of blur that falls as t^2 it is 94 %
  const double n = double(blur.size());
  double t = 0, b = 0, tt = 0, bb = 0, tb = 0;
  for (std::size_t i = 0; i < blur.size(); ++i) {
    t += print.pair[i], b += blur[i];
    tt += double(print.pair[i]) * print.pair[i], bb += blur[i] * blur[i], tb += print.pair[i] * blur[i];
  }
  return std::pow(tb - t * b / n, 2) > kExplained * (tt - t * t / n) * (bb - b * b / n);
}

void check_motion(const Sequence& sequence, const Motion& motion, const GrayCode* gray_code,
                  const FrameName& name, SequenceCheck& check) {
  const Series& print = motion.print;
  if (!print.known()) return;
  if (print.largest() > kMotionPx) return check_print(sequence, motion, name, check);
  Diagnostics& found = check.diagnostics;
  if (gray_code) {
    double by = 0;
    for (const StripeAxis axis : {StripeAxis::kColumn, StripeAxis::kRow})
      by = std::max(by, stripe_motion(sequence, *gray_code, axis).value_or(0));
    if (by > kStripeMotionPx) {
      found.warn("projector_moved",
                 "The projected frame moves, by " + format("%.1f", by) +
                     " projector pixels between coarse and fine stripes, while the board rests: fix the "
                     "projector, and let it warm up");
      return;
    }
  }
  if (focus_drifts(print))
    found.warn("focus_drift", "The camera's focus changes during the sequence: switch autofocus off");
}

void warn_overexposed(const Sequence::Clipping& clipping, Diagnostics& found) {
  found.warn("overexposed",
             "White is at full scale over " + format("%.0f %%", 100 * clipping.share) +
                 " of the lit pixels, which shifts edges of print and stripes; lower the exposure");
}

void check_exposure(const Sequence& sequence, const Sequence::Clipping& clipping, Diagnostics& found) {
  // A lamp's reflection is bright without the projector's light too.
  if (clipping.lamp > 0.003 || (clipping.share > 0.003 && clipping.white_grey < 235)) {
    found.warn("highlight", "A spot on the board is at full scale (" +
                                format("%.1f %%", 100 * clipping.share) +
                                " of the lit pixels) while its paper is not: a lamp or the projector is "
                                "reflected; turn the board a little or shade the lamp");
  } else if (const double contrast = sequence.contrast(); contrast < 20) {
    found.warn("low_contrast", "On the board white is only " + format("%.0f", contrast) +
                                   " grey levels brighter than black; raise the exposure or dim the room");
  }
}

/// Stripes that shake by their own width look as if the finest bit's frames were exchanged.
void check_order(const Sequence& sequence, const GrayCode& gray_code, const FrameName& name,
                 SequenceCheck& check) {
  const auto exchanged = find_exchanged_frames(sequence.frames(), gray_code);
  if (!exchanged) return;
  check.decoding_is_wrong = true;
  check.diagnostics.warn(
      "frames_exchanged",
      "The captures of " + name(exchanged->first) + " and " + name(exchanged->second) +
          (exchanged->pairs ? ", each with its inverse," : "") +
          " are exchanged: put the files back into their order, or capture this view again");
}

void check_frames(const Sequence& sequence, const Gains& gains, const FrameName& name, SequenceCheck& check) {
  const auto wrong = find_wrong_frame(sequence, gains);
  if (!wrong) return;
  check.decoding_is_wrong = true;
  if (wrong->torn) {
    const FramePair& pair = sequence.pair(wrong->pair);
    check.diagnostics.warn(
        "torn_frame", "The captures of " + name(pair.first) + " and " + name(pair.second) +
                          " complement each other in a part of their rows only: a capture shows two "
                          "frames, one above the other; expose for whole frames of the projector, or wait "
                          "longer, and capture this view again");
  } else {
    check.diagnostics.warn("stale_frame", stale_message(name, wrong->capture, wrong->shows));
  }
}

/// Stripe edges move both ways, as the frame before is light or dark there; waves all move the same way.
void check_lag(const Sequence& sequence, SequenceCheck& check) {
  const double lag = sequence.lag();
  if (!(lag > kLag)) return;
  check.decoding_is_wrong = !sequence.has_stripes();
  check.diagnostics.warn("lag", "Each capture still shows " + format("%.0f %%", 100 * lag) +
                                    " of the frame before: wait longer after each frame, and switch off the "
                                    "camera's noise reduction over time (3D, temporal)");
}

void check_noise(SequenceCheck& check) {
  if (check.noise > kNoisy)
    check.diagnostics.warn("noisy",
                           "Noise is " + format("%.0f %%", 100 * check.noise) +
                               " of the difference between white and black stripes: expose longer at a lower "
                               "gain, open the lens, or dim the room");
}

void check_scattered(const Sequence& sequence, SequenceCheck& check) {
  check.scattered = sequence.scattered();
  if (check.scattered > kScattered)
    check.diagnostics.note(
        "scattered_light",
        "Black stripes receive " + format("%.0f %%", 100 * check.scattered) +
            " of the light of white ones: glare in the camera's lens, or bright surfaces around; clean and "
            "shade the lens, dim what is around the board");
}

}  // namespace

std::string stale_message(const FrameName& name, int capture, int shows) {
  return "The capture of " + name(capture) + " still shows " + name(shows) +
         ": the camera was faster than the projector; capture this view again, waiting longer after each "
         "frame";
}

void find_cause(Sequence& sequence, const GrayCode* gray_code, const FrameName& name, SequenceCheck& check) {
  Diagnostics& found = check.diagnostics;
  if (sequence.lit().size() < kFewLit) {
    // Then black may be as bright as white.
    if (sequence.black_stripes() < -5 * kDarker) warn_exposure(-sequence.black_stripes(), found);
    return;
  }
  check.has_lit_board = sequence.has_board();
  // At full scale frames are alike whatever they show: nothing else can be told. Stretched contrast is at full scale as well.
  const Sequence::Clipping clipping = sequence.clipping();
  if (clipping.is_everywhere() && !sequence.spans_all_greys()) return warn_overexposed(clipping, found);
  check.gamma = sequence.estimate_gamma();
  Gains gains;
  for (int pair = 0; pair < sequence.pairs(); ++pair) gains.push_back(sequence.gain(pair));
  Motion motion;
  for (const auto& gain : gains) motion.gains.push_back(gain ? gain->all : 1);
  motion.print = follow(sequence, print_edges(sequence), motion.gains);
  motion.background_edges = background_edges(sequence);
  const bool shakes = motion.shakes();

  if (gray_code) check.noise = sequence.noise();
  // A print elsewhere changes the brightness of its pixels too.
  if (motion.has_clear_step()) return check_print(sequence, motion, name, check);
  if (gray_code && !shakes) check_order(sequence, *gray_code, name, check);
  if (!found.items.empty()) return;
  check_lag(sequence, check);
  if (!found.items.empty()) return;
  // No wrong frame makes black stripes darker than black. Stretched contrast makes pairs unequal, as a torn frame does, and
  // takes the brightest pixels to full scale.
  if (-sequence.black_stripes() > 5 * kDarker || sequence.spans_all_greys() ||
      lamps_flicker_strongly(sequence))
    check_brightness(sequence, gains, shakes, check);
  if (!found.items.empty()) return;
  // Between captures that shake, the finest stripes move by their own width: that is no other frame.
  if (!shakes) check_frames(sequence, gains, name, check);
  if (!found.items.empty()) return;
  if (clipping.share > kClipped && clipping.lamp < 0.25 * clipping.share) {
    warn_overexposed(clipping, found);
    return;
  }
  check_brightness(sequence, gains, shakes, check);
  if (found.items.empty() && gray_code) check_noise(check);
  if (found.items.empty()) check_motion(sequence, motion, gray_code, name, check);
  if (found.items.empty()) check_exposure(sequence, clipping, found);
  if (found.items.empty() && gray_code) check_scattered(sequence, check);
}

bool warn_if_overexposed(const Sequence& sequence, SequenceCheck& check) {
  const Sequence::Clipping clipping = sequence.clipping();
  if (clipping.share <= kClipped) return false;
  warn_overexposed(clipping, check.diagnostics);
  return true;
}

void find_cause_of_pair(const Sequence& sequence, SequenceCheck& check) {
  if (sequence.lit().size() < kFewLit) return;
  check.has_lit_board = sequence.has_board();
  if (warn_if_overexposed(sequence, check)) return;
  const auto gain = sequence.gain(0);
  if (!gain) return;
  Motion motion;
  motion.gains = {gain->all};
  motion.print = follow(sequence, print_edges(sequence), motion.gains);
  // One pair alone: no mean over many.
  constexpr double kMovedPx = 0.5, kMovedSigmas = 4;
  const auto has_moved = [&](const PairFit& fit, double px) {
    // Far away from the print every fit is uncertain.
    return fit.lost || px > kMovedPx + kMovedSigmas * fit.sigma || (px > kMovedPx && fit.in_place < kInPlace);
  };
  if (motion.print.size() == 1 && has_moved(motion.print.fit[0], motion.print.motion()[0].norm())) {
    const Background behind = background(sequence, background_edges(sequence), motion.print, motion.gains);
    const bool board = behind != Background::kMoves;
    check.diagnostics.warn(board ? "board_moved" : "camera_moved",
                           std::string(behind == Background::kRests ? "The board"
                                       : board                      ? "The board, or the camera,"
                                                                    : "The camera") +
                               " moved between the two captures by " +
                               format("%.1f px", motion.print.motion()[0].norm()) +
                               ": print and light do not fit together; fix it, and capture this view again");
    check.decoding_is_wrong = true;
    return;
  }
  constexpr double kChange = 0.05;
  if (std::abs(gain->all - 1) > kChange) warn_exposure(std::abs(gain->all - 1), check.diagnostics);
}

}  // namespace procam::pattern::internal
