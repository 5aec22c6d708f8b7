/// Light that is fit for a calibration, and light that is not.
#include "procam/session/checks.hpp"

#include <gtest/gtest.h>

#include <cstdio>

#include "light_checks.hpp"
#include "lit_scene.hpp"

namespace procam::session {
namespace {

using test::LitScene;

ImageU8 flat(const LitScene& scene, int level) {
  return ImageU8(scene.panel, 1, std::uint8_t(level));
}

ExposureCheck expose(const LitScene& scene, std::mt19937& random) {
  const ImageU8 white = seen(scene, flat(scene, 255), random), black = seen(scene, flat(scene, 0), random);
  return check_exposure(white, black, {0.7, 0.01});
}

TEST(Exposure, AcceptsAWellExposedBoard) {
  std::mt19937 random(1);
  for (int i = 0; i < 20; ++i) {
    const ExposureCheck check = expose({}, random);
    EXPECT_TRUE(check.diagnostics.items.empty()) << check.diagnostics.items[0].message;
    EXPECT_GT(check.lit_share, 0.8);
    EXPECT_NEAR(check.contrast, 180, 5);
    EXPECT_NEAR(check.brightest, 192, 8);
  }
}

TEST(Exposure, NamesWhatIsWrong) {
  std::mt19937 random(2);
  const auto code = [&](double step, double full) {
    LitScene scene;
    scene.step = step, scene.full = full;
    const ExposureCheck check = expose(scene, random);
    return check.diagnostics.items.empty() ? std::string("fine") : check.diagnostics.items.back().code;
  };
  EXPECT_EQ(code(1.0, 180), "fine");
  EXPECT_EQ(code(1.5, 180), "saturated");
  EXPECT_EQ(code(0.13, 180), "little_contrast");
  EXPECT_EQ(code(1.0, 8), "too_dark");
  EXPECT_EQ(code(1.0, 0), "not_lit");
}

/// 0.2 % of the lit pixels at full scale deserve a look; 5 % spoil the captures.
TEST(Exposure, CountsSaturatedPixels) {
  ImageU8 white(100, 100, 1, 180), black(100, 100, 1, 5);
  for (int i = 0; i < 20; ++i) white.at(i, 3) = 255;
  EXPECT_NE(check_exposure(white, black, {1, 0}).diagnostics.find("some_saturated"), nullptr);
  for (int y = 0; y < 5; ++y) std::fill_n(white.row(y), 100, std::uint8_t(254));
  EXPECT_TRUE(check_exposure(white, black, {1, 0}).diagnostics.failed());
}

ToneCheck ramp(const LitScene& scene, double drift, std::mt19937& random) {
  const ImageU8 paper = expose(scene, random).paper;
  std::vector<ToneSample> samples;
  LitScene now = scene;
  for (const int level : tone_levels()) {
    samples.push_back({level, mean_over(paper, seen(now, flat(scene, level), random))});
    now.step *= 1 + drift;
  }
  return check_tone(samples);
}

/// Means over 30000 pixels: noise is far below the limits, so a false alarm never shows.
TEST(Tone, FindsTheGammaOfProjectorAndCamera) {
  std::mt19937 random(3);
  for (const double gamma : {1.0, 1.8, 2.4}) {
    LitScene scene;
    scene.gamma = gamma;
    const ToneCheck check = ramp(scene, 0, random);
    EXPECT_NEAR(check.gamma, gamma, 0.04);
    EXPECT_LT(check.drift, 0.005);
    EXPECT_TRUE(check.diagnostics.items.empty());
  }
}

TEST(Tone, NamesAutomaticsAndClipping) {
  std::mt19937 random(4);
  EXPECT_NE(ramp({}, -0.01, random).diagnostics.find("light_drifts"), nullptr);
  LitScene bright;
  bright.full = 400;
  EXPECT_NE(ramp(bright, 0, random).diagnostics.find("clipped"), nullptr);
  const std::vector<ToneSample> flat_top{{0, 10}, {64, 60}, {128, 120}, {192, 199}, {255, 200}};
  EXPECT_NE(check_tone(flat_top).diagnostics.find("clipped"), nullptr);
  // A projector that dims itself on bright pictures.
  std::vector<ToneSample> dimmed;
  for (const int level : tone_levels()) dimmed.push_back({level, level < 200 ? 10.0 + level : 330.0 - level});
  EXPECT_NE(check_tone(dimmed).diagnostics.find("not_monotone"), nullptr);
  EXPECT_THROW(check_tone({{0, 1}, {128, 2}, {255, 3}}), std::invalid_argument);
}

NativeCheck look_at_checkers(const LitScene& scene, unsigned seed) {
  std::mt19937 random(seed);
  ImageU8 frames[2][4];
  for (auto& round : frames) {
    round[0] = seen(scene, flat(scene, 255), random);
    round[1] = seen(scene, flat(scene, 0), random);
    round[2] = seen(scene, pixel_checkerboard(scene.panel, false), random);
    round[3] = seen(scene, pixel_checkerboard(scene.panel, true), random);
  }
  const auto as_views = [](const ImageU8(&round)[4]) {
    return NativeFrames{round[0], round[1], round[2], round[3]};
  };
  return check_native_resolution(as_views(frames[0]), as_views(frames[1]));
}

/// Cameras that resolve the squares, barely do, or do not; noise of 1 to 4 grey levels; a camera with the
/// curve of sRGB. The beat of noise alone is the root of a covariance that is zero within sigma^2 /
/// sqrt(15000 pixels): a sigma of 6 % a pixel makes 0.5 %, and the limit of 4 % is 60 such deviations of the
/// covariance away.
TEST(NativeResolution, PassesAProjectorThatShowsPixelByPixel) {
  double largest = 0;
  for (const double camera_pixel : {0.35, 0.55, 0.93, 1.03, 1.1})
    for (const double camera_gamma : {1.0, 2.2})
      for (const double noise : {1.0, 16.0}) {
        LitScene scene;
        scene.camera_pixel = camera_pixel, scene.camera_gamma = camera_gamma, scene.noise_at_black = noise;
        const NativeCheck check = look_at_checkers(scene, unsigned(camera_pixel * 100 + noise));
        std::printf("native: camera pixel %.2f, camera gamma %.1f, noise %.0f: beat %.2f %%\n", camera_pixel,
                    camera_gamma, std::sqrt(noise), 100 * check.beat);
        EXPECT_TRUE(check.diagnostics.items.empty()) << camera_pixel << " " << camera_gamma;
        largest = std::max(largest, check.beat);
      }
  EXPECT_LT(largest, 0.75 * NativeCheck::kLargestBeat);
}

TEST(NativeResolution, NamesScalingAndKeystone) {
  struct Case {
    const char* what;
    double scale, keystone;
  };
  for (const Case& c :
       {Case{"scaled by 1.25", 1.25, 0}, Case{"scaled by 1.02", 1.02, 0}, Case{"scaled by 0.9", 0.9, 0},
        Case{"keystone of 10 %", 1, 0.1}, Case{"keystone of 2 %", 1, 0.02}})
    for (const double camera_pixel : {0.2, 0.55, 0.93}) {
      LitScene scene;
      scene.scale = c.scale, scene.keystone = c.keystone, scene.camera_pixel = camera_pixel;
      const NativeCheck check = look_at_checkers(scene, 7);
      std::printf("%s, camera pixel %.2f: beat %.1f %%\n", c.what, camera_pixel, 100 * check.beat);
      EXPECT_NE(check.diagnostics.find("resampled"), nullptr) << c.what << " " << camera_pixel;
    }
}

TEST(NativeResolution, SaysWhenItCannotTell) {
  LitScene scene;
  scene.full = 500;
  EXPECT_NE(look_at_checkers(scene, 8).diagnostics.find("not_checked"), nullptr);
}

}  // namespace
}  // namespace procam::session
