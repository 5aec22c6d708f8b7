#include "procam/session/capture.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include "delay_code.hpp"
#include "light_checks.hpp"
#include "same_picture.hpp"

namespace procam::session {
namespace {

constexpr double kSlice = 0.05;  // seconds between two ticks
constexpr double kPatience = 10;

Error camera_error(const std::string& why, const std::string& next) {
  return Error(ErrorKind::kDevice, "camera", why, next);
}

/// Waits for a frame; `patience_s` without one ends it, 0 never does.
device::SeenFrame wait_for_frame(const CaptureRig& stand, double after_s, double patience_s) {
  const double begin = device::now_s();
  while (true) {
    stand.tick();
    if (std::optional<device::SeenFrame> frame = stand.camera.next(after_s, kSlice)) return std::move(*frame);
    if (patience_s > 0 && device::now_s() - begin > patience_s)
      throw camera_error("no picture has come from it for " + std::to_string(int(patience_s)) + " s",
                         "check that it runs (and, for a folder, that its pictures land there)");
  }
}

ImageU8 flat(ImageSize size, int level) {
  return ImageU8(size, 1, std::uint8_t(level));
}

double mean(ViewU8 picture) {
  double sum = 0;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) sum += picture.at(x, y);
  return sum / (double(picture.width) * picture.height);
}

/// Frames reduced to 16x12 means: enough to find where the light switches, and small enough to keep all of
/// them.
struct CoarseFrame {
  static constexpr int kColumns = 16, kRows = 12;
  double time_s = 0;
  std::vector<double> level = std::vector<double>(kColumns * kRows, 0.0);
};

CoarseFrame coarse(const device::SeenFrame& frame) {
  CoarseFrame result;
  result.time_s = frame.time_s;
  const ImageU8& image = frame.image;
  for (int row = 0; row < CoarseFrame::kRows; ++row)
    for (int column = 0; column < CoarseFrame::kColumns; ++column) {
      const int left = column * image.width() / CoarseFrame::kColumns;
      const int right = (column + 1) * image.width() / CoarseFrame::kColumns;
      const int top = row * image.height() / CoarseFrame::kRows;
      const int bottom = (row + 1) * image.height() / CoarseFrame::kRows;
      double sum = 0;
      for (int y = top; y < bottom; ++y)
        for (int x = left; x < right; ++x) sum += image.at(x, y);
      result.level[std::size_t(row * CoarseFrame::kColumns + column)] =
          sum / std::max(1, (right - left) * (bottom - top));
    }
  return result;
}

/// The mean over the blocks that vary at least half as much as the one that varies most.
std::vector<BrightnessSample> brightness_where_it_varies(const std::vector<CoarseFrame>& frames) {
  constexpr std::size_t kBlocks = CoarseFrame::kColumns * CoarseFrame::kRows;
  std::vector<double> deviation(kBlocks);
  for (std::size_t block = 0; block < kBlocks; ++block) {
    double sum = 0, squares = 0;
    for (const CoarseFrame& frame : frames)
      sum += frame.level[block], squares += frame.level[block] * frame.level[block];
    const double n = double(frames.size());
    deviation[block] = std::sqrt(std::max(0.0, squares / n - (sum / n) * (sum / n)));
  }
  const double least = 0.5 * *std::max_element(deviation.begin(), deviation.end());
  std::vector<BrightnessSample> seen;
  for (const CoarseFrame& frame : frames) {
    double sum = 0, count = 0;
    for (std::size_t block = 0; block < kBlocks; ++block)
      if (deviation[block] >= least) sum += frame.level[block], ++count;
    seen.push_back({frame.time_s, sum / count});
  }
  return seen;
}

/// Shows a code and finds it in the frames.
std::optional<Delay> try_code(const CaptureRig& stand, double unit_s, double longest_s, unsigned seed) {
  constexpr int kParts = 40;
  const ImageU8 black = flat(stand.screen.size(), 0), white = flat(stand.screen.size(), 255);
  std::vector<LightSwitch> switches;
  std::vector<CoarseFrame> frames;
  double last = stand.screen.show(black);
  const auto listen_until = [&](double time_s) {
    while (last < time_s) {
      const device::SeenFrame frame = wait_for_frame(stand, last, kPatience);
      last = frame.time_s;
      frames.push_back(coarse(frame));
    }
  };
  listen_until(last + 4 * unit_s);
  bool is_white = false;
  for (const double duration : code_durations(kParts, unit_s, seed)) {
    is_white = !is_white;
    const double time = stand.screen.show(is_white ? white : black);
    switches.push_back({time, is_white});
    listen_until(time + duration);
  }
  listen_until(last + 6 * unit_s);
  return find_delay(switches, brightness_where_it_varies(frames), longest_s);
}

}  // namespace

std::optional<Delay> find_screen(const CaptureRig& stand) {
  // A code's parts must span several frames.
  constexpr int kFrames = 5;
  double last = stand.screen.show(flat(stand.screen.size(), 0));
  double first = 0;
  for (int i = 0; i < kFrames; ++i) {
    last = wait_for_frame(stand, last, kPatience).time_s;
    if (i == 0) first = last;
  }
  const double interval = (last - first) / (kFrames - 1);
  constexpr double kShortestUnit = 0.04;  // two pictures of a 60 Hz screen
  const double unit = std::max(kShortestUnit, interval);
  if (const auto delay = try_code(stand, unit, 36 * unit, 1)) return delay;
  return try_code(stand, 3 * unit, 108 * unit, 2);
}

Delay measure_delay(const CaptureRig& stand) {
  if (const std::optional<Delay> delay = find_screen(stand)) return *delay;
  throw camera_error(
      "its pictures do not follow what the screen shows",
      "point it at the projector's picture, choose the projector with --display, and turn off automatic "
      "exposure");
}

ShutterOptions shutter_options(const Delay& delay) {
  ShutterOptions options;
  options.wait_s = delay.settled_s + 0.5 * delay.frame_interval_s;
  options.patience_s = std::max(kPatience, 20 * delay.frame_interval_s);
  options.settling_s = std::max(options.settling_s, 8 * delay.frame_interval_s);
  return options;
}

Shutter::Shutter(const CaptureRig& stand, const ShutterOptions& options) : stand_(stand), options_(options) {}

double Shutter::show(ViewU8 picture) {
  const double time = stand_.screen.show(picture);
  after_s_ = time + options_.wait_s;
  return time;
}

ImageU8 Shutter::next_frame() {
  device::SeenFrame frame = wait_for_frame(stand_, after_s_, options_.patience_s);
  after_s_ = frame.time_s;
  return std::move(frame.image);
}

ImageU8 Shutter::capture_unchecked(ViewU8 picture) {
  show(picture);
  forget();
  return settle().image;
}

void Shutter::forget() {
  shown_before_ = seen_before_ = ImageU8();
}

TakenFrame Shutter::settle() {
  const double begin = after_s_;
  TakenFrame taken;
  taken.image = next_frame();
  while (true) {
    ImageU8 next = next_frame();
    if (next.size() != taken.image.size())
      throw camera_error("its pictures change their size", "let it run in one mode");
    const Change change = compare(taken.image, next, options_.noise);
    taken.steady = !change.any();
    taken.unsteady = change.largest;
    if (!taken.steady) on_rejected(taken.image, Rejected::kTorn);
    taken.image = std::move(next);
    if (taken.steady) return taken;
    if (after_s_ - begin > options_.settling_s) {
      // What neither ends nor is large is the light's flicker: noise, from now on.
      if (taken.unsteady <= options_.largest_flicker)
        options_.noise.at_black += 0.5 * taken.unsteady * taken.unsteady;
      return taken;
    }
  }
}

TakenFrame Shutter::settle_after(double shown_s, double wait_s) {
  after_s_ = shown_s + wait_s;
  return settle();
}

TakenFrame Shutter::capture_after_blank(ViewU8 picture) {
  constexpr double kBrightPicture = 64;
  const ImageU8 curtain = flat(picture.size(), mean(picture) > kBrightPicture ? 0 : 255);
  const double longest = 1 + 4 * options_.wait_s;
  const TakenFrame hidden = settle_after(show(curtain), longest);
  const double shown = show(picture);
  // From the first moment on: when does the curtain's last frame come?
  after_s_ = shown;
  double last_hidden = shown, interval = longest;
  for (double before = shown; after_s_ - shown < longest; before = after_s_) {
    const ImageU8 frame = next_frame();
    interval = std::min(interval, after_s_ - before);
    if (!compare(frame, hidden.image, options_.noise).any()) last_hidden = after_s_;
  }
  options_.wait_s = std::max(options_.wait_s, last_hidden - shown + 1.5 * interval);
  TakenFrame taken = settle();
  if (!compare(taken.image, hidden.image, options_.noise).any())
    throw camera_error("its pictures do not follow what the screen shows, or too faintly",
                       "check that it still sees the projector's picture, and run the same command again");
  return taken;
}

TakenFrame Shutter::take(ViewU8 picture) {
  if (options_.single_shot) {
    show(picture);
    return {next_frame()};
  }
  show(picture);
  TakenFrame taken = settle();
  const bool comparable = seen_before_.size() == taken.image.size() && !same_picture(picture, shown_before_);
  if (comparable && !compare(taken.image, seen_before_, options_.noise).any()) {
    on_rejected(taken.image, Rejected::kStale);
    taken = capture_after_blank(picture);
  }
  shown_before_ = copy_of(picture);
  seen_before_ = taken.image;
  return taken;
}

Diagnostics LightReport::diagnostics() const {
  Diagnostics all = exposure.diagnostics;
  all.append(tone.diagnostics);
  all.append(native.diagnostics);
  return all;
}

namespace {

/// Some frames pass first, so that not even a slow camera's transition counts as noise.
NoiseModel noise_of_white_and_black(Shutter& shutter) {
  constexpr int kFrames = 5, kFramesPassed = 2;
  constexpr double kAnyNoise = 1e4;  // until it is known
  shutter.options().noise = {kAnyNoise, 0};
  std::vector<std::vector<ImageU8>> images;
  std::vector<std::vector<ViewU8>> scenes;
  for (const int level : {255, 0}) {
    std::vector<ImageU8>& taken = images.emplace_back();
    shutter.capture_unchecked(flat(shutter.screen_size(), level));
    for (int i = 1; i < kFramesPassed; ++i) shutter.next_frame();
    for (int i = 0; i < kFrames; ++i) taken.push_back(shutter.next_frame());
  }
  for (const std::vector<ImageU8>& taken : images) scenes.emplace_back(taken.begin(), taken.end());
  return measure_noise_of_scenes(scenes);
}

}  // namespace

LightReport check_light(Shutter& shutter, const KeepFrame& keep) {
  const ImageSize size = shutter.screen_size();
  const ImageU8 white = flat(size, 255), black = flat(size, 0);
  LightReport report;

  report.noise = shutter.options().noise = noise_of_white_and_black(shutter);
  const ImageU8 first_white = shutter.take(white).image;
  report.exposure = check_exposure(first_white, shutter.take(black).image, report.noise);
  if (report.exposure.diagnostics.failed()) {
    keep("white", first_white);
    return report;
  }

  struct Round {
    ImageU8 white, black, checkers, inverse;
  };
  const auto play = [&](const std::string& name) {
    Round round;
    round.black = shutter.take(black).image;
    round.checkers = shutter.take(pixel_checkerboard(size, false)).image;
    round.inverse = shutter.take(pixel_checkerboard(size, true)).image;
    round.white = shutter.take(white).image;
    keep("black" + name, round.black);
    keep("checkers" + name, round.checkers);
    keep("inverse" + name, round.inverse);
    keep("white" + name, round.white);
    return round;
  };
  const Round first = play("_0"), second = play("_1");
  report.native = check_native_resolution({first.white, first.black, first.checkers, first.inverse},
                                          {second.white, second.black, second.checkers, second.inverse});
  std::vector<ToneSample> ramp;
  for (const int level : tone_levels()) {
    const ImageU8 seen = shutter.take(flat(size, level)).image;
    ramp.push_back({level, mean_over(report.exposure.paper, seen)});
    keep("ramp_" + std::to_string(ramp.size() - 1), seen);
  }
  report.tone = check_tone(ramp);
  shutter.forget();
  return report;
}

}  // namespace procam::session
