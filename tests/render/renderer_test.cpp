/// CpuRenderer: the same pixels by every way to compute them, and no more work for a frame than it needs.
#include <gtest/gtest.h>

#include <random>

#include "render/rooms.hpp"
#include "support/counted_allocations.hpp"

namespace procam {
namespace {

using render::CpuRenderer;
using render::RenderOptions;
using render::RenderWork;

ImageU8 random_picture(int width, int height, int channels, unsigned seed) {
  ImageU8 image(width, height, channels);
  std::mt19937 random(seed);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width * channels; ++x) image.row(y)[x] = std::uint8_t(random() & 255);
  return image;
}

/// A minified sheet through the lens, a magnified one before it (at 1.2 m they cut each other) that lets it
/// through, and a pixel surface that leaves the frame.
struct Stage {
  Projector projector = lopsided_projector(brown(-0.2));
  ImageU8 fine = random_picture(1501, 1100, 3, 3), glass = random_picture(45, 31, 4, 4),
          grey = random_picture(200, 99, 1, 5);
  Scene scene;

  explicit Stage(double glass_distance = 1.2) {
    scene.background[0] = 20, scene.background[1] = 90, scene.background[2] = 160;
    scene.items.push_back({tilted_sheet(projector, 0.6, 0.5, 1.4, 60).placement, fine});
    scene.items.push_back(
        {tilted_sheet(projector, 0.2, 0.25, glass_distance, 30, Vec2(400, 500)).placement, glass});
    PlacedPixels corner;
    corner.pixel_from_content << 210, 33, -40.3, -20, 160, 690.2, 0.1, 0.05, 1;
    scene.items.push_back({corner, grey});
  }
};

ImageU8 drawn(const Stage& stage, render::Filter filter, bool linear_light, int threads, int vector_bits) {
  RenderOptions options;
  options.filter = filter;
  options.linear_light = linear_light;
  options.threads = threads;
  options.vector_bits = vector_bits;
  return render::render(stage.scene, stage.projector, options);
}

bool equal(const ImageU8& a, const ImageU8& b) {
  return a.size() == b.size() &&
         std::equal(a.data(), a.data() + std::ptrdiff_t(a.width()) * a.height() * 3, b.data());
}

TEST(CpuRenderer, DrawsTheSameBitsInPlainCodeInVectorsAndOnAnyNumberOfThreads) {
  const Stage stage;
  for (const render::Filter filter : {render::Filter::kArea, render::Filter::kBilinear})
    for (const bool linear_light : {true, false}) {
      const ImageU8 plain = drawn(stage, filter, linear_light, 1, 0);
      EXPECT_TRUE(equal(drawn(stage, filter, linear_light, 1, 256), plain));
      EXPECT_TRUE(equal(drawn(stage, filter, linear_light, 1, 512), plain));
      EXPECT_TRUE(equal(drawn(stage, filter, linear_light, 3, 512), plain));
    }
  EXPECT_FALSE(equal(drawn(stage, render::Filter::kArea, true, 1, 512),
                     drawn(stage, render::Filter::kArea, false, 1, 512)));
}

// Every size of the last group of pixels in a row, at each of the frame's borders.
TEST(CpuRenderer, DrawsTheSameBitsInNarrowFrames) {
  const ImageU8 content = random_picture(60, 50, 4, 9);
  for (int width = 1; width < 20; ++width) {
    Stage stage;
    stage.projector = Projector{Camera{{width, 7}, {150, 143, 4, 7, 0.6}, NoDistortion{}}};
    PlacedPixels placed;
    placed.pixel_from_content << width + 3, 0.2, -1.2, 0.3, 9, -1.4, 0.01, 0.02, 1;
    stage.scene.items = {{placed, content}};
    for (const render::Filter filter : {render::Filter::kArea, render::Filter::kBilinear})
      for (const int bits : {256, 512})
        EXPECT_TRUE(equal(drawn(stage, filter, false, 1, bits), drawn(stage, filter, false, 1, 0)))
            << width << ", " << bits << " bits";
  }
}

TEST(CpuRenderer, AllocatesNothingForAFrameLikeTheLast) {
  Stage stage(0.7);
  for (const render::Filter filter : {render::Filter::kArea, render::Filter::kBilinear}) {
    RenderOptions options;
    options.filter = filter;
    options.linear_light = filter == render::Filter::kArea;
    options.threads = 2;
    CpuRenderer renderer(options);
    ImageU8 frame(stage.projector.size(), 3);
    PlacedPlane& sheet = std::get<PlacedPlane>(stage.scene.items[0].placement);
    const Vec3 there = sheet.projector_from_surface.translation, other = there + Vec3(0.01, 0.002, -0.004);
    for (int warm = 0; warm < 4; ++warm) {
      sheet.projector_from_surface.translation = warm % 2 ? there : other;
      renderer.render(stage.scene, stage.projector, frame);
    }
    const long before = test::allocations;
    renderer.render(stage.scene, stage.projector, frame);  // stands still
    ++stage.scene.items[0].content_revision;
    renderer.render(stage.scene, stage.projector, frame);  // a new picture
    EXPECT_EQ(test::allocations - before, 0);
    const ImageU8 seen = frame;
    if (kAllocationsAreCounted) EXPECT_GT(test::allocations - before, 0);
  }
}

TEST(CpuRenderer, MakesAnewOnlyWhatChanged) {
  Stage stage;
  CpuRenderer renderer;
  ImageU8 frame(stage.projector.size(), 3);
  const auto work = [&] {
    const RenderWork done = renderer.render(stage.scene, stage.projector, frame);
    EXPECT_TRUE(equal(frame, render::render(stage.scene, stage.projector)));
    return std::make_pair(done.contents, done.maps);
  };
  EXPECT_EQ(work(), std::make_pair(3, 3));
  EXPECT_EQ(work(), std::make_pair(0, 0));

  PlacedPlane& glass = std::get<PlacedPlane>(stage.scene.items[1].placement);
  glass.projector_from_surface.translation.x() += 0.02;
  EXPECT_EQ(work(), std::make_pair(0, 1));

  const ImageU8 other = random_picture(45, 31, 4, 77);  // into the same memory
  std::copy_n(other.data(), 45 * 31 * 4, stage.glass.data());
  ++stage.scene.items[1].content_revision;
  EXPECT_EQ(work(), std::make_pair(1, 0));

  stage.projector.inverse_camera.intrinsics.cy += 3;
  EXPECT_EQ(work(), std::make_pair(0, 3));
  stage.projector.inverse_camera.size = {700, 500};
  frame = ImageU8(700, 500, 3);
  EXPECT_EQ(work(), std::make_pair(0, 3));
  stage.scene.items.pop_back();
  EXPECT_EQ(work(), std::make_pair(0, 0));
}

// Looked at closer, a picture that was seen from afar needs nothing anew; from afar it needs its coarser
// levels.
TEST(CpuRenderer, AddsThePicturesCoarserLevelsWhenASurfaceMovesAway) {
  Stage stage;
  stage.scene.items.resize(1);
  CpuRenderer renderer;
  ImageU8 frame(stage.projector.size(), 3);
  stage.scene.items[0].placement = tilted_sheet(stage.projector, 1.5, 1.1, 1.4, 30).placement;
  EXPECT_EQ(renderer.render(stage.scene, stage.projector, frame).contents, 1);
  stage.scene.items[0].placement = tilted_sheet(stage.projector, 0.1, 0.08, 1.4, 30).placement;
  EXPECT_EQ(renderer.render(stage.scene, stage.projector, frame).contents, 1);
  EXPECT_TRUE(equal(frame, render::render(stage.scene, stage.projector)));
  stage.scene.items[0].placement = tilted_sheet(stage.projector, 1.5, 1.1, 1.4, 30).placement;
  EXPECT_EQ(renderer.render(stage.scene, stage.projector, frame).contents, 0);
  EXPECT_TRUE(equal(frame, render::render(stage.scene, stage.projector)));
}

TEST(CpuRenderer, AMovedSurfaceChangesItsOwnPixelsAlone) {
  Stage stage;
  CpuRenderer renderer;
  ImageU8 before(stage.projector.size(), 3), after = before;
  renderer.render(stage.scene, stage.projector, before);
  PlacedPixels& corner = std::get<PlacedPixels>(stage.scene.items[2].placement);
  corner.pixel_from_content(0, 2) += 30;
  renderer.render(stage.scene, stage.projector, after);
  int changed = 0;
  for (int y = 0; y < after.height(); ++y)
    for (int x = 0; x < after.width(); ++x) {
      const bool same = std::equal(&before.at(x, y), &before.at(x, y) + 3, &after.at(x, y));
      changed += !same;
      if (x > 260 || y < 600) {
        ASSERT_TRUE(same) << x << " " << y;
      }
    }
  EXPECT_GT(changed, 10000);
}

}  // namespace
}  // namespace procam
