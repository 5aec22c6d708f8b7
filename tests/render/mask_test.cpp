/// Masks: alpha from a picture of its own.
#include <gtest/gtest.h>

#include "render/rooms.hpp"

namespace procam {
namespace {

/// Two triangles with the corners of a sheet.
PlacedMesh as_mesh(const Sheet& sheet) {
  Mesh mesh;
  for (const Vec2& uv : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)}) {
    const Vec2 p = sheet.plane_point(uv.x(), uv.y());
    mesh.vertices.emplace_back(p.x(), p.y(), 0);
    mesh.uv.push_back(uv);
  }
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return {std::make_shared<const Mesh>(mesh), sheet.placement.projector_from_surface};
}

/// Soft and hard, and nowhere the same on both sides.
ImageU8 lopsided_mask() {
  ImageU8 mask(61, 34);
  for (int y = 0; y < 34; ++y)
    for (int x = 0; x < 61; ++x)
      mask.at(x, y) = std::uint8_t((x / 7 + y / 5) % 3 == 0 ? 255 : (x * 4 + y) % 256);
  return mask;
}

class Masks : public ::testing::TestWithParam<std::tuple<int, render::Filter, bool>> {};

/// On content of one colour a mask is the same as its alpha in the content, on every kind of surface.
TEST_P(Masks, AreTheContentsAlpha) {
  const auto [kind, filter, linear] = GetParam();
  const Projector projector = lopsided_projector(brown(-0.2));
  const Sheet sheet = tilted_sheet(projector, 0.9, 0.5, 1.7, 40);
  Placement placement = sheet.placement;
  if (kind == 1) placement = as_mesh(sheet);
  if (kind == 2) {
    PlacedPixels pixels;
    pixels.pixel_from_content << 700, 30, 90.3, -20, 500, 120.7, 0.2, -0.1, 1;
    placement = pixels;
  }
  const ImageU8 mask = lopsided_mask(), color(1, 1, 3, 200);
  ImageU8 both(61, 34, 4, 200);
  for (int y = 0; y < 34; ++y)
    for (int x = 0; x < 61; ++x) both.at(x, y, 3) = mask.at(x, y);
  Scene masked, in_content;
  masked.background[1] = in_content.background[1] = 60;
  masked.items.push_back({placement, color});
  masked.items[0].mask = mask;
  in_content.items.push_back({placement, both});
  render::RenderOptions options;
  options.filter = filter;
  options.linear_light = linear;
  const ImageU8 a = render::render(masked, projector, options),
                b = render::render(in_content, projector, options);
  int worst = 0, drawn = 0;
  for (int y = 0; y < a.height(); ++y)
    for (int x = 0; x < a.width() * 3; ++x) {
      worst = std::max(worst, std::abs(int(a.row(y)[x]) - int(b.row(y)[x])));
      drawn += a.row(y)[x] > 60;
    }
  EXPECT_GT(drawn, 100000);
  // Light is rounded again; where there is little of it, one step of light is several values.
  EXPECT_LE(worst, linear ? 4 : 2);
}

INSTANTIATE_TEST_SUITE_P(EverySurface, Masks,
                         ::testing::Combine(::testing::Values(0, 1, 2),
                                            ::testing::Values(render::Filter::kArea,
                                                              render::Filter::kBilinear),
                                            ::testing::Bool()));

TEST(Mask, LetsThroughWhatLiesBehind) {
  const Projector projector = lopsided_projector();
  const Sheet wall = tilted_sheet(projector, 1.6, 1.1, 2.1, 20),
              poster = tilted_sheet(projector, 0.5, 0.4, 1.4, 35);
  const ImageU8 red(1, 1, 1, 90), white(1, 1, 1, 255), nothing(3, 2, 1, 0), all(5, 4, 1, 255);
  Scene scene;
  scene.items.push_back({poster.placement, white});
  scene.items.push_back({wall.placement, red});
  const ImageU8 covered = render::render(scene, projector);
  scene.items[0].mask = all;
  const ImageU8 same = render::render(scene, projector);
  scene.items[0].mask = nothing;
  const ImageU8 through = render::render(scene, projector);
  EXPECT_EQ(covered.at(540, 361), 255);
  EXPECT_EQ(same.at(540, 361), 255);
  EXPECT_EQ(through.at(540, 361), 90);
}

TEST(Mask, IsPreparedAgainWhenItsRevisionChanges) {
  const Projector projector = lopsided_projector();
  const ImageU8 white(1, 1, 1, 255);
  ImageU8 mask(8, 8, 1, 255), frame(projector.size(), 3);
  Scene scene;
  scene.items.push_back({tilted_sheet(projector, 0.9, 0.5, 1.7, 40).placement, white});
  scene.items[0].mask = mask;
  render::CpuRenderer renderer;
  EXPECT_EQ(renderer.render(scene, projector, frame).contents, 2);
  EXPECT_EQ(renderer.render(scene, projector, frame).contents, 0);
  mask = ImageU8(8, 8, 1, 0);
  scene.items[0].mask = mask;
  ++scene.items[0].mask_revision;
  EXPECT_EQ(renderer.render(scene, projector, frame).contents, 1);
  EXPECT_EQ(frame.at(540, 361), 0);
  scene.items[0].mask = {};
  renderer.render(scene, projector, frame);
  EXPECT_EQ(frame.at(540, 361), 255);
}

TEST(Mask, MustBeGrey) {
  const Projector projector = lopsided_projector();
  const ImageU8 white(1, 1, 1, 255), rgb(4, 4, 3, 255);
  Scene scene;
  scene.items.push_back({tilted_sheet(projector, 0.9, 0.5, 1.7, 40).placement, white});
  scene.items[0].mask = rgb;
  EXPECT_THROW(render::render(scene, projector), std::invalid_argument);
}

}  // namespace
}  // namespace procam
