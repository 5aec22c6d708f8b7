#include "procam/pattern/decoded_pixels.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "support/expect_error.hpp"

namespace procam::pattern {
namespace {

const ImageSize kProjector{640, 480};
const float kNaN = std::numeric_limits<float>::quiet_NaN();

/// A tilted plane in a lopsided camera image, its left part unlit; noise of 0.05 px, three times as large
/// where the white image is dark.
struct Scene {
  ImageF pixels{330, 210, 2};
  ImageU8 white{330, 210};

  explicit Scene(unsigned seed = 1) {
    std::mt19937 random(seed);
    std::normal_distribution<float> normal;
    for (int y = 0; y < 210; ++y)
      for (int x = 0; x < 330; ++x) {
        const bool is_dark = (x / 20 + y / 20) % 2 == 0;
        white.at(x, y) = is_dark ? 40 : 200;
        const float w = 1 + 2e-4f * float(x) + 1e-4f * float(y), sigma = is_dark ? 0.15f : 0.05f;
        pixels.at(x, y, 0) = (30 + 1.7f * float(x) + 0.1f * float(y)) / w + sigma * normal(random);
        pixels.at(x, y, 1) = (55 - 0.2f * float(x) + 1.6f * float(y)) / w + sigma * normal(random);
        if (x < 30) pixels.at(x, y, 0) = pixels.at(x, y, 1) = kNaN;
      }
  }
  void change(void (*change)(float* pixel)) {
    for (int y = 0; y < 210; ++y)
      for (int x = 0; x < 330; ++x) change(&pixels.at(x, y));
  }
};

TEST(LightMapOfPixels, EstimatesTheErrorByBrightness) {
  const Scene scene;
  const LightMap map = light_map(scene.pixels, scene.white, kProjector);
  // 15000 differences a class: their median is known to 1.5 %.
  for (int a = 0; a < 2; ++a) {
    EXPECT_NEAR(map.sigma.at(50, 30, a), 0.05, 0.004);  // light
    EXPECT_NEAR(map.sigma.at(50, 50, a), 0.15, 0.012);  // dark
  }
  EXPECT_FALSE(map.decoded(10, 30));
  EXPECT_EQ(map.pixel.at(10, 30, 0), 0);
  EXPECT_TRUE(map.diagnostics.items.size() == 1 && map.diagnostics.find("decoded_share") != nullptr);
}

/// Stripes of four pixels, as their middles.
TEST(LightMapOfPixels, KnowsTheRoundingOfWholeStripes) {
  Scene scene;
  scene.change([](float* p) {
    for (int a = 0; a < 2; ++a) p[a] = 4 * std::floor((p[a] + 0.5f) / 4) + 1.5f;
  });
  const LightMap map = light_map(scene.pixels, scene.white, kProjector);
  EXPECT_GE(map.sigma.at(50, 30, 0), 4 / std::sqrt(12.f) - 1e-3f);
}

TEST(LightMapOfPixels, TakesFillValuesAsUndecoded) {
  const auto decoded_at_left = [](const Scene& scene) {
    const LightMap map = light_map(scene.pixels, scene.white, kProjector);
    EXPECT_TRUE(map.decoded(200, 100));
    EXPECT_EQ(map.diagnostics.find("projector_size"), nullptr);
    return map.decoded(10, 30);
  };
  for (const auto& fill :
       {+[](float* p) { p[0] = std::isnan(p[0]) ? 0 : p[0], p[1] = std::isnan(p[1]) ? 0 : p[1]; },
        +[](float* p) { p[0] = std::isnan(p[0]) ? -1 : p[0], p[1] = std::isnan(p[1]) ? -1 : p[1]; },
        +[](float* p) { p[0] = std::isnan(p[0]) ? 65535 : p[0], p[1] = std::isnan(p[1]) ? 65535 : p[1]; }}) {
    Scene scene;
    scene.change(fill);
    EXPECT_FALSE(decoded_at_left(scene));
  }
}

/// The pixel (0, 0) of a projector is a pixel: a patch of it beside its neighbours is light.
TEST(LightMapOfPixels, KeepsTheFirstPixelOfTheFrame) {
  Scene scene;
  scene.change(
      [](float* p) { p[0] = std::round(0.2f * (p[0] - 100)), p[1] = std::round(0.2f * (p[1] - 40)); });
  const LightMap map = light_map(scene.pixels, scene.white, {128, 96});
  EXPECT_EQ(map.diagnostics.find("zeros_undecoded"), nullptr);
}

/// Stripes of two pixels, given by their numbers, put the light at half of its coordinates: 0.8 m of error on a wall, and
/// every check passed.
TEST(LightMapOfPixels, RefusesNumbersOfStripes) {
  const auto map_of = [](float width) {
    Scene scene;
    for (int y = 0; y < 210; ++y)
      for (int x = 30; x < 330; ++x) {
        scene.pixels.at(x, y, 0) = std::floor(639.f * float(x - 30) / 299 / width);
        scene.pixels.at(x, y, 1) = std::floor(479.f * float(y) / 209 / width);
      }
    return scene;
  };
  const Scene numbers = map_of(2), pixels = map_of(1);
  EXPECT_ERROR(light_map(numbers.pixels, numbers.white, kProjector), kInput, "stripes of 2 pixels");
  EXPECT_EQ(light_map(pixels.pixels, pixels.white, kProjector).diagnostics.find("projector_size"), nullptr);
}

TEST(LightMapOfPixels, RemarksOnMirroredAndMisfittingMaps) {
  Scene exchanged;
  exchanged.change([](float* p) { std::swap(p[0], p[1]); });
  EXPECT_NE(light_map(exchanged.pixels, exchanged.white, kProjector).diagnostics.find("map_mirrored"),
            nullptr);
  Scene backwards;
  backwards.change([](float* p) { p[1] = 479 - p[1]; });
  EXPECT_NE(light_map(backwards.pixels, backwards.white, kProjector).diagnostics.find("map_mirrored"),
            nullptr);
  Scene turned;  // a projector that hangs upside down
  turned.change([](float* p) { p[0] = 639 - p[0], p[1] = 479 - p[1]; });
  EXPECT_EQ(light_map(turned.pixels, turned.white, kProjector).diagnostics.find("map_mirrored"), nullptr);

  const Scene good;
  EXPECT_NE(light_map(good.pixels, good.white, {500, 480}).diagnostics.find("projector_size"), nullptr);
  EXPECT_ERROR(light_map(good.pixels, good.white, {200, 480}), kInput, "beyond the projector's width");
  Scene shares;
  shares.change([](float* p) { p[0] /= 640, p[1] /= 480; });
  EXPECT_ERROR(light_map(shares.pixels, shares.white, kProjector), kInput, "between 0 and 1");
  Scene none;
  none.change([](float* p) { p[0] = kNaN; });
  EXPECT_ERROR(light_map(none.pixels, none.white, kProjector), kInput, "no pixel");
}

}  // namespace
}  // namespace procam::pattern
