#include "procam/render/cpu.hpp"

#include <gtest/gtest.h>

#include <random>

#include "render/rooms.hpp"

namespace procam {
namespace {

using render::render;
using render::RenderOptions;

ImageU8 noise(int width, int height, int channels, unsigned seed) {
  ImageU8 image(width, height, channels);
  std::mt19937 random(seed);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width * channels; ++x) image.row(y)[x] = std::uint8_t(random() & 255);
  return image;
}

/// The content covers the whole pixels from (x, y), one texel a pixel.
PlacedPixels one_to_one(int x, int y, const ImageU8& content) {
  PlacedPixels placed;
  placed.pixel_from_content << content.width(), 0, x - 0.5, 0, content.height(), y - 0.5, 0, 0, 1;
  return placed;
}

Projector small_projector() {
  return {Camera{{97, 61}, {150, 143, 41, 77, 0.6}, NoDistortion{}}};
}

TEST(Render, ShowsOneToOneContentUnchanged) {
  const ImageU8 content = noise(41, 23, 3, 5);
  Scene scene;
  scene.background[0] = 10, scene.background[1] = 200, scene.background[2] = 31;
  scene.items.push_back({one_to_one(30, 20, content), content});
  for (const bool linear_light : {true, false}) {
    const ImageU8 frame = render(scene, small_projector(), options(linear_light, 2));
    for (int y = 0; y < frame.height(); ++y)
      for (int x = 0; x < frame.width(); ++x)
        for (int c = 0; c < 3; ++c) {
          const bool inside = x >= 30 && y >= 20 && x < 71 && y < 43;
          ASSERT_EQ(frame.at(x, y, c), inside ? content.at(x - 30, y - 20, c) : scene.background[c])
              << x << " " << y << " " << c;
        }
  }
}

TEST(Render, DrawsTheSamePixelsWhateverTheNumberOfThreads) {
  const Projector projector = lopsided_projector(brown(-0.2));
  const ImageU8 content = noise(600, 400, 3, 7), over = noise(90, 130, 4, 8);
  Scene scene;
  scene.items.push_back({tilted_sheet(projector, 0.4, 0.3, 1.4, 55).placement, content});
  scene.items.push_back({tilted_sheet(projector, 0.1, 0.2, 1.2, 30, Vec2(400, 500)).placement, over});
  const ImageU8 one = render(scene, projector, options(true, 1));
  for (const int threads : {2, 5}) {
    const ImageU8 many = render(scene, projector, options(true, threads));
    EXPECT_TRUE(std::equal(one.data(), one.data() + 1024 * 768 * 3, many.data()));
  }
}

TEST(Render, CoversExactlyTheAreaOfTheContent) {
  const Projector projector = lopsided_projector();
  const Sheet sheet = tilted_sheet(projector, 0.202, 0.211, 1.6, 47);
  const ImageU8 white(3, 2, 1, 255);
  Scene scene;
  scene.items.push_back({sheet.placement, white});
  const ImageU8 frame = render(scene, projector, options(false, 0));
  double covered = 0, twice_area = 0;
  for (int y = 0; y < 768; ++y)
    for (int x = 0; x < 1024; ++x) covered += frame.at(x, y) / 255.0;
  const Vec2 corner[4] = {
      *projector.project(sheet.in_projector(0, 0)), *projector.project(sheet.in_projector(1, 0)),
      *projector.project(sheet.in_projector(1, 1)), *projector.project(sheet.in_projector(0, 1))};
  for (int i = 0; i < 4; ++i) {
    const Vec2 &a = corner[i], &b = corner[(i + 1) % 4];
    twice_area += a.x() * b.y() - a.y() * b.x();
  }
  // Some 800 border pixels, each rounded by up to half a value (sigma 0.29): 3.5 sigma of their sum.
  EXPECT_NEAR(covered, 0.5 * std::abs(twice_area), 3.5 * 0.29 / 255 * std::sqrt(800));
}

TEST(Render, PutsLaterSurfacesOverEarlierOnesAndBlendsAlphaInLight) {
  const ImageU8 below(20, 20, 3, 255);
  ImageU8 glass(20, 20, 4, 0);  // black, half transparent
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 20; ++x) glass.at(x, y, 3) = 128;
  Scene scene;
  scene.items.push_back({one_to_one(10, 10, below), below});
  scene.items.push_back({one_to_one(20, 10, glass), glass});
  const ImageU8 frame = render(scene, small_projector());
  EXPECT_EQ(frame.at(15, 15), 255);
  EXPECT_EQ(frame.at(25, 15), 187);  // half the light: 255 * srgb(127/255)
  EXPECT_EQ(frame.at(35, 15), 0);
  EXPECT_EQ(render(scene, small_projector(), options(false, 1)).at(25, 15), 127);
}

TEST(Render, DrawsAnyNumberOfSurfaces) {
  std::vector<ImageU8> contents;
  for (int i = 0; i < 40; ++i) contents.emplace_back(5, 4, 1, std::uint8_t(100 + i));
  Scene scene;
  for (int i = 0; i < 40; ++i)
    scene.items.push_back(
        {one_to_one(2 + i % 10 * 9, 3 + i / 10 * 12, contents[std::size_t(i)]), contents[std::size_t(i)]});
  const ImageU8 frame = render(scene, small_projector());
  for (int i = 0; i < 40; ++i) EXPECT_EQ(frame.at(4 + i % 10 * 9, 5 + i / 10 * 12), 100 + i);
}

// A floor that runs from behind the projector to far ahead: below the horizon the content, above it nothing.
TEST(Render, StopsAtTheHorizon) {
  Projector projector = lopsided_projector(brown(-0.1));
  projector.inverse_camera.intrinsics.cy = 300;  // the horizon crosses the picture
  const ImageU8 white(8, 8, 1, 255);
  Sheet floor{4e3, 4e3, {}};
  floor.placement.plane_from_content << floor.width, 0, -0.4 * floor.width, 0, floor.height,
      -0.5 * floor.height, 0, 0, 1;
  Mat3 rotation;  // x right, y towards the projector, z down into the floor; rolled a little
  rotation << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  floor.placement.projector_from_surface =
      Pose(Mat3(Eigen::AngleAxisd(0.05, Vec3::UnitZ()).toRotationMatrix() * rotation), Vec3(0, 0.9, 0));
  Scene scene;
  scene.items.push_back({floor.placement, white});
  const ImageU8 frame = render(scene, projector);
  int lit = 0, dark = 0;
  for (int y = 0; y < 768; y += 3)
    for (int x = 0; x < 1024; x += 5) {
      const auto p = floor.landed(projector, Vec2(x, y));
      const bool reaches = p && p->norm() < 800;
      if (reaches) {
        ASSERT_EQ(frame.at(x, y), 255) << x << " " << y;
        ++lit;
      }
      if (!p) {
        ASSERT_EQ(frame.at(x, y), 0) << x << " " << y;
        ++dark;
      }
    }
  EXPECT_GT(lit, 10000);
  EXPECT_GT(dark, 10000);
}

TEST(Render, DrawsNothingBehindTheProjectorOrEdgeOn) {
  const ImageU8 white(8, 8, 1, 255);
  const Projector projector = lopsided_projector();
  PlacedPlane behind = tilted_sheet(projector, 0.2, 0.3, 1.5, 30).placement;
  behind.projector_from_surface.translation *= -1;
  PlacedPlane edge_on;
  edge_on.projector_from_surface =
      Pose(Eigen::AngleAxisd(radians(90), Vec3::UnitY()).toRotationMatrix(), Vec3(0, -0.2, 1.0));
  Scene scene;
  scene.items.push_back({behind, white});
  scene.items.push_back({edge_on, white});
  const ImageU8 frame = render(scene, projector);
  EXPECT_TRUE(
      std::all_of(frame.data(), frame.data() + 1024 * 768 * 3, [](std::uint8_t v) { return v == 0; }));
}

TEST(Render, RefusesFramesAndContentOfAnotherShape) {
  const Projector projector = small_projector();
  ImageU8 frame(97, 60, 3), grey(97, 61, 1), two_channels(4, 4, 2);
  EXPECT_THROW(render(Scene{}, projector, frame.view()), std::invalid_argument);
  EXPECT_THROW(render(Scene{}, projector, grey.view()), std::invalid_argument);
  Scene scene;
  scene.items.push_back({PlacedPixels{}, two_channels});
  EXPECT_THROW(render(scene, projector), std::invalid_argument);
  scene.items[0].content = ViewU8();
  EXPECT_THROW(render(scene, projector), std::invalid_argument);
}

// No memory lies behind these views: what is refused is not looked at.
TEST(Render, RefusesWhatIsTooLargeBeforeTakingMemory) {
  const auto refusal = [](const Scene& scene, const Projector& projector) -> std::string {
    try {
      render(scene, projector);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kInput);
      return error.what();
    }
    return "drawn";
  };
  Projector projector = small_projector();
  std::uint8_t pixel[4] = {};
  Scene scene;
  scene.items.push_back({PlacedPixels{}, ViewU8(pixel, 100000, 100000, 3)});
  EXPECT_EQ(refusal(scene, projector),
            "content: it has 100000 x 100000 pixels; give a picture of at most 268435456 pixels");
  scene.items[0].content = ViewU8(pixel, 1, 1, 3);
  scene.items[0].mask = ViewU8(pixel, 2, 268435455, 1);
  EXPECT_EQ(refusal(scene, projector),
            "mask: it has 2 x 268435455 pixels; give a picture of at most 268435456 pixels");
  projector.inverse_camera.size = {65536, 65536};
  EXPECT_EQ(refusal(Scene{}, projector),
            "frame: the projector has 65536 x 65536 pixels; give one of at most 16384 pixels a side");
}

}  // namespace
}  // namespace procam
