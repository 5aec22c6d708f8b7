#include "procam/track/clock.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace procam::track {
namespace {

/// A sender whose clock is ahead by `offset` and gains `drift`, over a network that adds exponential jitter
/// to a constant delay. Stamps are Unix time, so that digits count.
struct Link {
  double offset = 12.5, drift = 40e-6, delay = 0.03, jitter = 0.004;
  std::mt19937_64 random{7};

  double stamp(double time) const { return 1.7e9 + offset + time * (1 + drift); }
  double arrival(double time) {
    return time + delay + std::exponential_distribution<double>(1 / jitter)(random);
  }
};

TEST(Clock, FindsTimeAndDriftBelowTheJitter) {
  Link link;
  Clock clock;
  double worst = 0, sigma = 0;
  for (int k = 0; k < 30 * 120; ++k) {
    const double time = 500 + k / 30.0;
    ASSERT_EQ(clock.observe(link.stamp(time), link.arrival(time)), ClockVerdict::kTaken) << k;
    if (k < 30 * 60) continue;
    const Clock::Estimate estimate = clock.estimate();
    worst = std::max(worst, std::abs(clock.time(link.stamp(time)) - time - link.delay));
    sigma = std::max(sigma, estimate.sigma);
    // A window of 60 s whose ends are known to about 0.1 ms.
    EXPECT_NEAR(estimate.drift, -link.drift, 6e-6);
    EXPECT_NEAR(estimate.jitter, link.jitter, 0.5 * link.jitter);
  }
  // The jitter's minimum over a second is 0.13 ms, that of the hull's corners less.
  EXPECT_LT(worst, 0.3e-3);
  EXPECT_LT(worst, 3 * sigma);
  EXPECT_LT(sigma, 0.5e-3);
  RecordProperty("worst_us", int(1e6 * worst));
}

TEST(Clock, IsOfUseFromTheFirstMessage) {
  Link link;
  link.jitter = 1e-4;
  Clock clock;
  EXPECT_EQ(clock.time(3.0), 3.0);
  clock.observe(link.stamp(2), link.arrival(2));
  EXPECT_NEAR(clock.time(link.stamp(2.5)), 2.5 + link.delay, 2e-3);
}

/// Steps of the sender's clock: seconds that it is set forward, and messages until the time is right again.
struct Step {
  double by;
  int messages;
};
class ClockStep : public ::testing::TestWithParam<Step> {};
TEST_P(ClockStep, IsNoticedAndRecoveredFrom) {
  const auto [by, messages] = GetParam();
  Link link;
  Clock clock;
  int wrong = 0, doubtful = 0;
  for (int k = 0; k < 30 * 60; ++k) {
    const double time = k / 30.0;
    if (k == 30 * 30) link.offset += by;
    const ClockVerdict verdict = clock.observe(link.stamp(time), link.arrival(time));
    if (verdict == ClockVerdict::kDoubtful) {
      ++doubtful;
      EXPECT_GE(k, 30 * 30);
    } else if (std::abs(clock.time(link.stamp(time)) - time - link.delay) > 0.008) {
      ++wrong;
    }
  }
  EXPECT_EQ(clock.estimate().jumps, 1u);
  EXPECT_LE(wrong + doubtful, messages);
  EXPECT_NEAR(clock.time(link.stamp(70)), 70 + link.delay, 3e-3);
}
INSTANTIATE_TEST_SUITE_P(BothWays, ClockStep,
                         ::testing::Values(Step{3600, 5}, Step{-3600, 13}, Step{0.5, 5}, Step{-0.5, 13},
                                           Step{0.05, 5}, Step{-0.05, 130}));

TEST(Clock, MessagesThatQueuedUpAreNoJump) {
  Link link;
  link.drift = 0;
  Clock clock;
  for (int k = 0; k < 300; ++k) clock.observe(link.stamp(k / 30.0), link.arrival(k / 30.0));
  // The network holds half a second back and then hands it out at once.
  for (int k = 0; k < 15; ++k) clock.observe(link.stamp(10 + k / 30.0), 10.55);
  EXPECT_EQ(clock.observe(link.stamp(10.6), 10.6 + link.delay), ClockVerdict::kTaken);
  EXPECT_EQ(clock.estimate().jumps, 0u);
  EXPECT_NEAR(clock.time(link.stamp(11)), 11 + link.delay, 1e-3);
}

TEST(Clock, OneWrongStampIsDoubtfulAndForgotten) {
  Link link;
  Clock clock;
  for (int k = 0; k < 300; ++k) {
    clock.observe(link.stamp(k / 30.0), link.arrival(k / 30.0));
    if (k % 50 == 49) {
      EXPECT_EQ(clock.observe(link.stamp(k / 30.0) - 4e8 + k, k / 30.0 + 0.03), ClockVerdict::kDoubtful);
    }
  }
  EXPECT_EQ(clock.estimate().jumps, 0u);
  EXPECT_NEAR(clock.time(link.stamp(10)), 10 + link.delay, 1e-3);
}

TEST(Clock, AKnownOffsetIsTakenAsItIs) {
  ClockOptions options;
  options.known_offset = -1.7e9;
  Clock clock(options);
  EXPECT_EQ(clock.observe(1.7e9 + 5, 5.2), ClockVerdict::kTaken);
  EXPECT_NEAR(clock.time(1.7e9 + 5), 5, 1e-6);
  EXPECT_THROW(clock.observe(NAN, 1), std::invalid_argument);
}

}  // namespace
}  // namespace procam::track
