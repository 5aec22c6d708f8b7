/// Frames of one picture, of two, and of parts of both.
#include "procam/session/change.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "lit_scene.hpp"

namespace procam::session {
namespace {

using test::LitScene;

ImageU8 stripes(ImageSize size, int width, bool inverse) {
  ImageU8 picture(size);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) picture.at(x, y) = (x / width) % 2 == (inverse ? 0 : 1) ? 255 : 0;
  return picture;
}

NoiseModel noise_of(const LitScene& scene) {
  return {scene.noise_at_black + 1.0 / 12, scene.noise_per_level};
}

/// 130 blocks an image, 1 in 10^10 each: a false alarm in 60 pairs has a probability below 10^-5. The noise
/// model in use is half of the true one in the second round, which the floor of one grey level forgives.
TEST(Compare, FindsNoChangeInNoise) {
  LitScene scene;
  std::mt19937 random(3);
  const ImageU8 picture = stripes(scene.panel, 12, false);
  for (int i = 0; i < 60; ++i) {
    const ImageU8 a = seen(scene, picture, random), b = seen(scene, picture, random);
    EXPECT_FALSE(compare(a, b, noise_of(scene)).any()) << i;
    if (i < 10) {
      EXPECT_FALSE(compare(a, b, {0.51, 0.0075}).any()) << i;
    }
  }
}

/// A torn frame's seam anywhere: even a strip of eight rows with the other picture in it is seen, and stripes
/// so fine that the camera barely resolves them are.
TEST(Compare, FindsTheTornPart) {
  LitScene scene;
  std::mt19937 random(4);
  for (const int width : {2, 3, 12, 60}) {
    const ImageU8 a = stripes(scene.panel, width, false), b = stripes(scene.panel, width, true);
    for (const int rows : {8, 40, 110}) {
      const ImageU8 whole = seen(scene, b, random);
      ImageU8 torn = seen(scene, b, random);
      const ImageU8 old = seen(scene, a, random);
      for (int y = 0; y < rows; ++y) std::copy_n(old.row(y), old.width(), torn.row(y));
      const Change change = compare(torn, whole, noise_of(scene));
      EXPECT_TRUE(change.any()) << width << " " << rows;
      EXPECT_GT(change.share, 0.5 * rows / whole.height());
      EXPECT_LT(change.share, double(rows + 16) / whole.height());
    }
  }
}

TEST(Compare, SaysByHowMuchItChanged) {
  ImageU8 a(64, 48, 1, 100), b = a;
  for (int y = 16; y < 32; ++y)
    for (int x = 16; x < 32; ++x) b.at(x, y) = 107;
  const Change change = compare(a, b, {1, 0});
  EXPECT_DOUBLE_EQ(change.share, 1.0 / 12);
  EXPECT_NEAR(change.largest, std::sqrt(49.0 - 2), 1e-9);
  EXPECT_THROW(compare(a, ImageU8(48, 64), {1, 0}), std::invalid_argument);
}

/// From 4 pairs of 130 blocks the medians are right to some 2 %; a quarter is many sigmas.
TEST(MeasureNoise, MeasuresIt) {
  LitScene scene;
  std::mt19937 random(5);
  std::vector<ImageU8> frames;
  for (int i = 0; i < 5; ++i) frames.push_back(seen(scene, stripes(scene.panel, 40, false), random));
  for (int y = 0; y < 40; ++y) std::fill_n(frames[2].row(y), frames[2].width(), std::uint8_t(90));  // torn
  const NoiseModel noise = measure_noise({frames.begin(), frames.end()});
  for (const double grey : {10.0, 100.0, 180.0})
    EXPECT_NEAR(noise.variance(grey) / noise_of(scene).variance(grey), 1, 0.25) << grey;
}

/// A camera with gamma 2: grey = sqrt(255 light), so dark pixels are the noisiest. Neither a flat scene nor fine stripes
/// count as a change; a block that is ten levels brighter does.
TEST(MeasureNoise, KnowsTheNoiseOfACameraWithAGamma) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  const auto camera = [&](const auto& light) {
    ImageU8 image(192, 112);
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x) {
        const double linear =
            std::clamp(light(x, y) + std::sqrt(0.6 + 0.03 * light(x, y)) * normal(random), 0.0, 255.0);
        image.at(x, y) = std::uint8_t(std::lround(std::sqrt(255 * linear)));
      }
    return image;
  };
  const auto lamp = [](int x, int y) { return 1 + 30.0 * x / 192 + 10.0 * y / 112; };
  const auto veil = [](int x, int) { return 0.5 + 1.0 * x / 192; };
  std::vector<ImageU8> white, black;
  for (int i = 0; i < 5; ++i) white.push_back(camera(lamp)), black.push_back(camera(veil));
  const NoiseModel noise =
      measure_noise_of_scenes({{white.begin(), white.end()}, {black.begin(), black.end()}});
  const auto stripes = [&](int x, int y) { return x / 3 % 2 == 0 ? lamp(x, y) : veil(x, y); };
  for (int i = 0; i < 20; ++i) {
    EXPECT_FALSE(compare(camera(lamp), camera(lamp), noise).any());
    EXPECT_FALSE(compare(camera(veil), camera(veil), noise).any());
    EXPECT_FALSE(compare(camera(stripes), camera(stripes), noise).any());
  }
  ImageU8 changed = camera(lamp);
  for (int y = 32; y < 64; ++y)
    for (int x = 96; x < 128; ++x) changed.at(x, y) = std::uint8_t(changed.at(x, y) + 10);
  EXPECT_TRUE(compare(camera(lamp), changed, noise).any());
}

TEST(MeasureNoise, KeepsTheRoundingOfANoiselessCamera) {
  const ImageU8 a(64, 48, 1, 100);
  EXPECT_DOUBLE_EQ(measure_noise({a, a}).variance(100), 1.0 / 12);
}

}  // namespace
}  // namespace procam::session
