#include "procam/pattern/phase_shift.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/gray_code_world.hpp"

namespace procam::pattern {
namespace {

using test::GrayCodeWorld;

/// A projector with a tone curve: light = 255 (grey / 255)^gamma.
std::vector<ImageU8> with_gamma(std::vector<ImageU8> frames, double gamma) {
  for (ImageU8& frame : frames)
    for (int y = 0; y < frame.height(); ++y)
      for (int x = 0; x < frame.width(); ++x)
        frame.at(x, y) = std::uint8_t(std::lround(255 * std::pow(frame.at(x, y) / 255.0, gamma)));
  return frames;
}

struct Outcome {
  LightMap map;
  double rms = 0;    ///< a coordinate, projector pixels
  double worst = 0;  ///< projector pixels
  double score = 0;  ///< mean (error / sigma)^2
  int decoded = 0, lit = 0;
};

/// Decodes what `world` captures of the frames, and compares with the truth a few pixels inside the picture.
Outcome decode_world(const GrayCodeWorld& world, const PhaseShift& shown, double gamma = 1) {
  const std::vector<ImageU8> captures = test::capture_all(world, with_gamma(frames(shown), gamma));
  Outcome outcome;
  outcome.map = decode(test::views_of(captures), shown);
  for (int y = 3; y < world.camera.height - 3; ++y)
    for (int x = 3; x < world.camera.width - 3; ++x) {
      const Vec2 truth = world.projector_pixel(Vec2(x, y));
      const ImageSize size = shown.projector_size;
      if (truth.x() < 2 || truth.y() < 2 || truth.x() > size.width - 3 || truth.y() > size.height - 3)
        continue;
      ++outcome.lit;
      const auto pixel = outcome.map.projector_pixel(x, y);
      if (!pixel) continue;
      ++outcome.decoded;
      for (int d = 0; d < 2; ++d) {
        const double error = (*pixel)[d] - truth[d];
        outcome.rms += error * error;
        outcome.worst = std::max(outcome.worst, std::abs(error));
        outcome.score += std::pow(error / double(outcome.map.sigma.at(x, y, d)), 2);
      }
    }
  outcome.rms = std::sqrt(outcome.rms / (2.0 * outcome.decoded));
  outcome.score /= 2.0 * outcome.decoded;
  return outcome;
}

class PhaseShiftLaws : public ::testing::TestWithParam<WaveNumber> {
 protected:
  /// Two coarser waves, or four bits.
  PhaseShift shown() const { return {{107, 93}, 6, GetParam()}; }
};

TEST_P(PhaseShiftLaws, DecodesWhatItShowed) {
  const Outcome outcome = decode_world(GrayCodeWorld{}, shown());
  EXPECT_GT(outcome.decoded, 0.97 * outcome.lit);
  EXPECT_LT(outcome.rms, 0.02);
  EXPECT_LT(outcome.worst, 0.12);
}

/// Some 40 thousand coordinates: were the sigmas and the world exact, the mean score would be 1 +- 0.01. The
/// world samples its light to 0.014 px, which adds 0.15.
TEST_P(PhaseShiftLaws, StatesItsErrorUnderNoise) {
  GrayCodeWorld world;
  world.noise_at_black = 10, world.noise_per_level = 0.05;
  const Outcome outcome = decode_world(world, shown());
  EXPECT_GT(outcome.decoded, 0.9 * outcome.lit);
  EXPECT_LT(outcome.worst, 3);  // no wave miscounted
  EXPECT_NEAR(outcome.score, 1.15, 0.2);
}

/// Waves long enough for blur to leave the tone curve's harmonics: with four steps nothing would decode.
TEST_P(PhaseShiftLaws, ToneCurveMovesNothing) {
  PhaseShift long_waves = shown();
  long_waves.period = 24;
  const Outcome outcome = decode_world(GrayCodeWorld{}, long_waves, 2.2);
  EXPECT_GT(outcome.decoded, 0.97 * outcome.lit);
  EXPECT_LT(outcome.rms, 0.025);
}

TEST_P(PhaseShiftLaws, BlurMovesNothing) {
  GrayCodeWorld world;
  world.projector_blur = 1.2, world.camera_blur = 1.5;
  const Outcome outcome = decode_world(world, shown(), 2.2);
  EXPECT_GT(outcome.decoded, 0.9 * outcome.lit);
  EXPECT_LT(outcome.rms, 0.06);
}

TEST_P(PhaseShiftLaws, RefusesSaturatedPixelsAndSaysSo) {
  GrayCodeWorld world;
  world.white_level = 320;
  const Outcome outcome = decode_world(world, shown());
  EXPECT_EQ(outcome.decoded, 0);
  EXPECT_NE(outcome.map.diagnostics.find("saturated"), nullptr);
}

TEST_P(PhaseShiftLaws, LeavesUnlitPixelsOut) {
  GrayCodeWorld world;
  world.projector_from_camera_offset = Vec2(48.3, 2.1);  // the picture ends in the middle of the image
  world.noise_at_black = 2;
  const Outcome outcome = decode_world(world, shown());
  int strays = 0;
  for (int y = 0; y < world.camera.height; ++y)
    for (int x = 0; x < world.camera.width; ++x)
      if (world.projector_pixel(Vec2(x, y)).x() > 110) strays += outcome.map.decoded(x, y);
  EXPECT_LE(strays, 2);
  EXPECT_GT(outcome.decoded, 0.95 * outcome.lit);
}

TEST_P(PhaseShiftLaws, RefusesCapturesOfAnotherPattern) {
  const std::vector<ImageU8> captures = test::capture_all(GrayCodeWorld{}, frames(shown()));
  std::vector<ViewU8> views = test::views_of(captures);
  views.pop_back();
  EXPECT_THROW(decode(views, shown()), Error);
  PhaseShift odd = shown();
  odd.period = 7;
  EXPECT_THROW(frames(odd), std::invalid_argument);
}

INSTANTIATE_TEST_SUITE_P(WaveNumbers, PhaseShiftLaws,
                         ::testing::Values(WaveNumber::kCoarserWaves, WaveNumber::kGrayCode),
                         [](const auto& kind) {
                           return std::string(kind.param == WaveNumber::kGrayCode ? "GrayCode"
                                                                                  : "CoarserWaves");
                         });

TEST(PhaseShift, CountsItsFrames) {
  const PhaseShift waves{{1024, 768}}, both{{1024, 768}, 16, WaveNumber::kGrayCode};
  EXPECT_EQ(frame_count(waves), 32);
  EXPECT_EQ(frame_count(both), 46);
  const PhaseShift small{{131, 103}, 16, WaveNumber::kGrayCode};
  EXPECT_EQ(int(frames(small).size()), frame_count(small));
}

}  // namespace
}  // namespace procam::pattern
