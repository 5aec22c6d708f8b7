/// Frames taken from a camera with faults, in made-up time: is each one of the picture that was shown?
#include <gtest/gtest.h>

#include <cstdio>
#include <deque>
#include <random>

#include "light_checks.hpp"
#include "procam/session/capture.hpp"

namespace procam::session {
namespace {

constexpr ImageSize kScreen{64, 48};

/// A screen and a camera on one clock of their own. The camera sees the screen itself, some time later, with
/// noise.
struct World {
  double now = 0, delay = 0.12, interval = 1 / 30.0, noise = 1;
  double stale = 0, torn = 0;  ///< shares of frames, once the delay has been measured
  bool faulty = false;
  double flicker = 0;                   ///< grey levels, of the lamp above
  double late_from = 1e9, late_by = 0;  ///< from some time on the delay grows
  double contrast = 0.6;
  std::mt19937 random{1};
  std::deque<std::pair<double, ImageU8>> shown;

  ImageU8 screen_at(double time) const {
    ImageU8 picture(kScreen);
    for (const auto& [t, image] : shown)
      if (t <= time) picture = image;
    return picture;
  }
};

class Screen : public device::FrameSink {
 public:
  explicit Screen(World& world) : world_(world) {}
  ImageSize size() const override { return kScreen; }
  double show(ViewU8 picture) override {
    world_.now += 0.004;
    ImageU8 copy(picture.size());
    for (int y = 0; y < picture.height; ++y) std::copy_n(picture.row(y), picture.width, copy.row(y));
    world_.shown.emplace_back(world_.now, copy);
    if (world_.shown.size() > 60) world_.shown.pop_front();
    return world_.now;
  }
  device::WindowEvent poll() override { return device::WindowEvent::kNone; }

 private:
  World& world_;
};

class Camera : public device::FrameSource {
 public:
  explicit Camera(World& world) : world_(world) {}
  std::optional<device::SeenFrame> next(double after_s, double) override {
    while (next_ <= after_s) expose();
    ImageU8 image = expose();
    return device::SeenFrame{std::move(image), world_.now};
  }

 private:
  /// The frame that arrives at next_.
  ImageU8 expose() {
    std::uniform_real_distribution<double> uniform;
    const double delay = world_.delay + (next_ > world_.late_from ? world_.late_by : 0);
    const ImageU8 light = world_.screen_at(next_ - delay);
    const bool stale = uniform(world_.random) < world_.stale && world_.faulty;
    const bool torn = uniform(world_.random) < world_.torn && world_.faulty;
    const int old_rows = stale ? kScreen.height : torn ? int(uniform(world_.random) * kScreen.height) : 0;
    // A driver's ring of buffers: what is stale in it is several frames old.
    constexpr std::size_t kRing = 4;
    ring_.push_back(light);
    if (ring_.size() > kRing) ring_.pop_front();
    const ImageU8& old = ring_.front();
    std::normal_distribution<double> normal(0, world_.noise);
    ImageU8 image(kScreen);
    constexpr double kHalfTheRate = 94.248;  // radians a second
    const double lamp = 20 + world_.flicker * std::sin(kHalfTheRate * next_);
    for (int y = 0; y < kScreen.height; ++y)
      for (int x = 0; x < kScreen.width; ++x) {
        const double grey =
            lamp + world_.contrast * (y < old_rows ? old : light).at(x, y) + normal(world_.random);
        image.at(x, y) = std::uint8_t(std::min(255.0, std::max(0.0, grey + 0.5)));
      }
    world_.now = next_;
    next_ += world_.interval;
    return image;
  }

  World& world_;
  double next_ = 0.01;
  std::deque<ImageU8> ring_;
};

ImageU8 stripes(int width, bool inverse) {
  ImageU8 picture(kScreen);
  for (int y = 0; y < kScreen.height; ++y)
    for (int x = 0; x < kScreen.width; ++x) picture.at(x, y) = (x / width) % 2 == (inverse ? 0 : 1) ? 255 : 0;
  return picture;
}

double rms_to(const ImageU8& image, const ImageU8& picture, const World& world) {
  double sum = 0;
  for (int y = 0; y < kScreen.height; ++y)
    for (int x = 0; x < kScreen.width; ++x) {
      const double difference = image.at(x, y) - 20 - world.contrast * picture.at(x, y);
      sum += difference * difference;
    }
  return std::sqrt(sum / (kScreen.width * kScreen.height));
}

/// A shutter whose noise is that of the world's camera, after its delay was measured.
struct ReadyShutter {
  explicit ReadyShutter(World& world)
      : screen(world), camera(world), shutter({screen, camera}, options_for(world)) {}

  ShutterOptions options_for(const World& world) {
    ShutterOptions options = shutter_options(measure_delay({screen, camera}));
    options.noise = {world.noise * world.noise + 1.0 / 12, 0};
    return options;
  }

  Screen screen;
  Camera camera;
  Shutter shutter;
};

struct Outcome {
  int wrong = 0, torn = 0, stale = 0, unsteady = 0;
};

/// 200 pictures after the delay was measured; the frame must be of the picture, to the noise.
Outcome take_many(World& world) {
  ReadyShutter ready(world);
  Shutter& shutter = ready.shutter;
  world.faulty = true;
  Outcome outcome;
  shutter.on_rejected = [&](const ImageU8&, Rejected why) {
    ++(why == Rejected::kTorn ? outcome.torn : outcome.stale);
  };
  for (int i = 0; i < 200; ++i) {
    const ImageU8 picture = stripes(1 + (i / 2) % 13, i % 2 == 1);
    const TakenFrame taken = shutter.take(picture);
    outcome.wrong += rms_to(taken.image, picture, world) > 1.2 * world.noise + 0.3;
    outcome.unsteady += !taken.steady;
  }
  return outcome;
}

TEST(MeasureDelay, FindsItOnAStand) {
  for (const double delay : {0.02, 0.12, 0.5}) {
    World world;
    world.delay = delay;
    Screen screen(world);
    Camera camera(world);
    const Delay found = measure_delay({screen, camera});
    // The end of the code is not waited for when the delay is long: fewer switches bound it.
    EXPECT_NEAR(found.delay_s, delay, 0.5 * world.interval);
    EXPECT_NEAR(found.frame_interval_s, world.interval, 1e-6);
  }
}

TEST(MeasureDelay, SaysThatTheCameraSeesNothingOfTheScreen) {
  World world;
  world.contrast = 0;
  Screen screen(world);
  Camera camera(world);
  try {
    measure_delay({screen, camera});
    FAIL() << "a delay was found in noise";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kDevice);
  }
}

/// 12 blocks, 1 in 10^10 each: no false alarm in 200 pictures, ever.
TEST(Shutter, TakesTheFirstFramesOfAFaultlessCamera) {
  World world;
  const Outcome outcome = take_many(world);
  EXPECT_EQ(outcome.wrong, 0);
  EXPECT_EQ(outcome.torn + outcome.stale + outcome.unsteady, 0);
}

/// One frame in seven stale, one in seven torn: they come in pairs, too. A pair of stale frames agrees with
/// itself and is caught by the picture before; a torn one disagrees with its successor.
TEST(Shutter, RefusesStaleAndTornFrames) {
  Outcome sum;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    World world;
    world.stale = world.torn = 1 / 7.0;
    world.random.seed(seed);
    const Outcome outcome = take_many(world);
    sum.wrong += outcome.wrong, sum.torn += outcome.torn, sum.stale += outcome.stale;
  }
  std::printf("1000 pictures: %d wrong; refused %d torn, %d stale\n", sum.wrong, sum.torn, sum.stale);
  EXPECT_EQ(sum.wrong, 0);
  EXPECT_GT(sum.torn, 100);
  EXPECT_GT(sum.stale, 3);
}

/// A lamp at half the camera's rate, by 3 grey levels: no two frames agree, until the shutter takes that for
/// noise. The first pictures cost three seconds, the others no more than without it.
TEST(Shutter, LearnsThatTheLightFlickers) {
  World world;
  world.flicker = 3;
  ReadyShutter ready(world);
  Shutter& shutter = ready.shutter;
  int unsteady = 0;
  const double begin = world.now;
  for (int i = 0; i < 50; ++i) {
    const ImageU8 picture = stripes(1 + (i / 2) % 13, i % 2 == 1);
    const TakenFrame taken = shutter.take(picture);
    EXPECT_LT(rms_to(taken.image, picture, world), 5) << i;
    unsteady += !taken.steady;
  }
  EXPECT_GE(unsteady, 1);
  EXPECT_LE(unsteady, 4);
  EXPECT_LT(world.now - begin, 50 * 0.3 + 4 * 3.5);
}

TEST(Shutter, TakesTheFirstFrameOfACameraTriggeredByHand) {
  World world;
  Screen screen(world);
  Camera camera(world);
  ShutterOptions options;
  options.single_shot = true;
  options.wait_s = world.delay + world.interval;
  Shutter shutter({screen, camera}, options);
  for (int i = 0; i < 4; ++i) {
    const double before = world.now;
    EXPECT_LT(rms_to(shutter.take(stripes(4, i % 2 == 1)).image, stripes(4, i % 2 == 1), world), 1.5);
    EXPECT_LT(world.now - before, options.wait_s + 2 * world.interval);
  }
}

/// A camera whose delay grows by four frames after it was measured.
TEST(Shutter, NoticesThatTheCameraHasBecomeLaterAndWaits) {
  World world;
  world.late_from = 12, world.late_by = 0.14;
  const Outcome outcome = take_many(world);
  EXPECT_EQ(outcome.wrong, 0);
  EXPECT_GE(outcome.stale, 1);
  EXPECT_LE(outcome.stale, 5) << "the shutter should have learnt to wait longer";
}

/// Stripes of one level of grey in 255 change nothing that the camera could see: the curtain proves the frame
/// new.
TEST(Shutter, TakesPicturesThatTheCameraCannotTellApart) {
  World world;
  ReadyShutter ready(world);
  Shutter& shutter = ready.shutter;
  int stale = 0;
  shutter.on_rejected = [&](const ImageU8&, Rejected why) { stale += why == Rejected::kStale; };
  const ImageU8 a(kScreen, 1, 128), b(kScreen, 1, 129);
  shutter.take(a);
  EXPECT_LT(rms_to(shutter.take(b).image, b, world), 1.5);
  EXPECT_EQ(stale, 1);
  shutter.take(b);
  EXPECT_EQ(stale, 1) << "the same picture again is no suspicion";
}

TEST(Shutter, GivesUpWhenTheScreenIsNoLongerSeen) {
  World world;
  ReadyShutter ready(world);
  Shutter& shutter = ready.shutter;
  shutter.take(stripes(4, false));
  world.contrast = 0;
  shutter.take(stripes(4, true));  // that changed, at least
  EXPECT_THROW(shutter.take(stripes(5, true)), Error);
}

/// White, black, ramp and checkerboards through the whole chain: this screen is linear and its own pixels are
/// seen.
TEST(CheckLight, ReportsAFaultlessStand) {
  World world;
  Screen screen(world);
  Camera camera(world);
  const CaptureRig stand{screen, camera};
  Shutter shutter(stand, shutter_options(measure_delay(stand)));
  std::vector<std::string> kept;
  const LightReport report =
      check_light(shutter, [&](const std::string& name, const ImageU8&) { kept.push_back(name); });
  EXPECT_TRUE(report.diagnostics().items.empty()) << report.diagnostics().items[0].message;
  EXPECT_NEAR(report.tone.gamma, 1, 0.03);
  EXPECT_NEAR(report.exposure.contrast, 153, 2);
  EXPECT_NEAR(report.noise.variance(100), 1 + 1.0 / 12, 0.3);
  EXPECT_LT(report.native.beat, 0.01);
  EXPECT_EQ(kept.size(), 8 + tone_levels().size());
}

/// A machine under load: from the grey levels on, pictures come to light four frames later than was measured.
TEST(CheckLight, MeasuresTheToneOfACameraThatHasBecomeLater) {
  World world;
  Screen screen(world);
  Camera camera(world);
  const CaptureRig stand{screen, camera};
  Shutter shutter(stand, shutter_options(measure_delay(stand)));
  const LightReport report = check_light(shutter, [&](const std::string& name, const ImageU8&) {
    if (name == "white_1") world.late_from = world.now, world.late_by = 0.14;
  });
  EXPECT_TRUE(report.diagnostics().items.empty()) << report.diagnostics().items[0].message;
  EXPECT_NEAR(report.tone.gamma, 1, 0.03);
}

}  // namespace
}  // namespace procam::session
