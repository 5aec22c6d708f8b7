/// The delay between showing and seeing, from made-up brightness with a known delay.
#include "procam/session/delay.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include "delay_code.hpp"

namespace procam::session {
namespace {

struct Scene {
  double interval = 1 / 30.0, delay = 0.1, exposure = 0.01, jitter = 0;
  double noise = 0.5, dark = 20, bright = 90;
  double dropped = 0;  ///< share of frames that never arrive
  int switches = 24;
  unsigned seed = 1;
};

struct Recording {
  std::vector<LightSwitch> switches;
  std::vector<BrightnessSample> seen;
};

double white_share(const std::vector<LightSwitch>& switches, double from, double to) {
  double sum = 0;
  constexpr int kSteps = 40;
  for (int i = 0; i < kSteps; ++i) {
    const double t = from + (i + 0.5) * (to - from) / kSteps;
    bool white = !switches.front().white;
    for (const LightSwitch& s : switches)
      if (s.time_s <= t) white = s.white;
    sum += white;
  }
  return sum / kSteps;
}

/// A frame that arrives at t has seen the screen from t - delay - exposure/2 to t - delay + exposure/2.
Recording record(const Scene& scene) {
  Recording recording;
  double t = 5;
  bool white = false;
  for (const double duration : code_durations(scene.switches, std::max(0.04, scene.interval), scene.seed)) {
    white = !white;
    recording.switches.push_back({t, white});
    t += duration;
  }
  std::mt19937 random(scene.seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  for (double frame = 4.7 + uniform(random) * scene.interval; frame < t + 0.3; frame += scene.interval) {
    const double middle = frame - scene.delay;
    const double share =
        white_share(recording.switches, middle - scene.exposure / 2, middle + scene.exposure / 2 + 1e-9);
    const double level = scene.dark + (scene.bright - scene.dark) * share + scene.noise * normal(random);
    const double arrival = frame + scene.jitter * uniform(random);
    if (uniform(random) >= scene.dropped) recording.seen.push_back({arrival, level});
  }
  return recording;
}

/// Delays of less than a frame up to several parts of the code, cameras of 10 to 60 frames a second. With
/// some 24 switches at random phases the best lags are those between two arrivals nearest a switch, so the
/// error stays within a quarter of the frame interval (one bound in 24 switches; never beyond, for these
/// seeds).
TEST(FindDelay, FindsShortAndLongDelays) {
  for (const double interval : {1 / 60.0, 1 / 30.0, 0.1})
    for (const double delay : {0.012, 0.05, 0.13, 0.31, 0.72}) {
      Scene scene;
      scene.interval = interval, scene.delay = delay, scene.exposure = 0.3 * interval;
      scene.seed = unsigned(1000 * delay + 10000 * interval);
      const Recording recording = record(scene);
      const auto found = find_delay(recording.switches, recording.seen, 36 * std::max(0.04, interval));
      ASSERT_TRUE(found) << interval << " " << delay;
      EXPECT_NEAR(found->delay_s, delay, 0.25 * interval) << interval;
      EXPECT_NEAR(found->frame_interval_s, interval, 1e-6);
      EXPECT_GT(found->correlation, 0.95);
      EXPECT_GE(found->settled_s, found->delay_s);
    }
}

/// Twenty flashes, cameras and delays of a show: each within 2 ms. Frames whose arrival jitters by a
/// millisecond, exposures from a tenth of the interval to most of it; 60 draws, none beyond for these seeds.
TEST(FindDelay, TwentyFlashesAreEnoughForTwoMilliseconds) {
  double worst = 0, squares = 0;
  int count = 0;
  for (unsigned seed = 1; seed <= 30; ++seed)
    for (const double interval : {1 / 30.0, 1 / 60.0}) {
      Scene scene;
      scene.switches = 40;
      scene.interval = interval, scene.exposure = interval * (0.1 + 0.027 * seed), scene.noise = 2;
      scene.jitter = 0.001, scene.delay = 0.02 + 0.004 * seed, scene.seed = seed;
      const Recording recording = record(scene);
      const auto found = find_delay(recording.switches, recording.seen, 1.4);
      ASSERT_TRUE(found) << seed;
      const double error = found->delay_s - scene.delay - 0.0005;
      worst = std::max(worst, std::abs(error));
      squares += error * error;
      ++count;
    }
  EXPECT_LT(worst, 0.002);
  RecordProperty("rms_us", int(1e6 * std::sqrt(squares / count)));
  RecordProperty("worst_us", int(1e6 * worst));
}

/// A frame is all new once the whole exposure lies after the switch: half the exposure after the delay, at
/// the latest, and a frame interval shows at least that much of it in 24 switches, or none of it.
TEST(FindDelay, KnowsWhenALongExposureHasSettled) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    Scene scene;
    scene.exposure = 0.03, scene.delay = 0.15, scene.noise = 1, scene.seed = seed;
    const Recording recording = record(scene);
    const auto found = find_delay(recording.switches, recording.seen, 1.4);
    ASSERT_TRUE(found);
    EXPECT_GT(found->settled_s, 0.15 + 0.006) << seed;
    EXPECT_LT(found->settled_s, 0.15 + 0.015 + 0.001) << seed;
  }
}

TEST(FindDelay, SurvivesJitterNoiseAndMissingFrames) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Scene scene;
    scene.jitter = 0.03, scene.noise = 12, scene.dropped = 0.2, scene.delay = 0.21, scene.seed = seed;
    const Recording recording = record(scene);
    const auto found = find_delay(recording.switches, recording.seen, 1.4);
    ASSERT_TRUE(found) << seed;
    EXPECT_NEAR(found->delay_s, 0.21 + 0.015, 0.02) << seed;
    EXPECT_GE(found->settled_s, found->delay_s);
  }
}

/// Brightness that has nothing to do with the code. A correlation of 0.8 over 60 frames of noise is 8 sigmas
/// off; over 200 lags and 300 seeds a false alarm has a probability below 10^-9. Slow drift correlates more,
/// and is the harder case.
TEST(FindDelay, FindsNothingInNoiseOrDrift) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    Scene scene;
    scene.bright = scene.dark, scene.noise = 3, scene.seed = seed;
    Recording recording = record(scene);
    EXPECT_FALSE(find_delay(recording.switches, recording.seen, 1.4)) << seed;
    for (BrightnessSample& frame : recording.seen)
      frame.level += 30 * frame.time_s + 10 * std::sin(3 * frame.time_s);
    EXPECT_FALSE(find_delay(recording.switches, recording.seen, 1.4)) << seed;
  }
}

/// An even code fits at every second part: such an answer is none.
TEST(FindDelay, RefusesAnAmbiguousCode) {
  Recording recording;
  for (int i = 0; i < 24; ++i) recording.switches.push_back({0.1 * i, i % 2 == 0});
  for (int k = 0; k < 72; ++k) {
    const double t = 0.033 * k;
    const double middle = t - 0.12;
    recording.seen.push_back({t, middle >= 0 && int(middle / 0.1) % 2 == 0 ? 100.0 : 10.0});
  }
  EXPECT_FALSE(find_delay(recording.switches, recording.seen, 1.0));
}

TEST(FindDelay, NeedsEnoughToGoBy) {
  Recording recording = record({});
  const std::vector<BrightnessSample> few(recording.seen.begin(), recording.seen.begin() + 12);
  EXPECT_FALSE(find_delay(recording.switches, few, 1.4));
  EXPECT_FALSE(find_delay({}, recording.seen, 1.4));
  EXPECT_THROW(find_delay(recording.switches, recording.seen, 0), std::invalid_argument);
}

}  // namespace
}  // namespace procam::session
