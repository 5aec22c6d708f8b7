#include "procam/render/preview.hpp"

#include <gtest/gtest.h>

#include "render/rooms.hpp"

namespace procam {
namespace {

// Drawn through the lens and seen from the front, the content is a rectangle of the sheet's own shape again,
// its quadrants where they belong.
TEST(Preview, ShowsTheContentUndistorted) {
  const Projector projector = lopsided_projector(brown(-0.2));
  const Sheet sheet = tilted_sheet(projector, 0.2, 0.15, 1.6, 60);
  ImageU8 content(80, 60, 3, 0);  // red, green / blue, white
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 80; ++x) {
      content.at(x, y, 0) = (x < 40) == (y < 30) ? 255 : 0;
      content.at(x, y, 1) = x >= 40 ? 255 : 0;
      content.at(x, y, 2) = y >= 30 ? 255 : 0;
    }
  Scene scene;
  scene.items.push_back({sheet.placement, content});
  const ImageU8 frame = render::render(scene, projector);
  const auto viewpoint = render::facing_viewpoint(scene);
  ASSERT_TRUE(viewpoint);
  const ImageU8 view = render::preview(scene, projector, frame, *viewpoint);
  const auto seen = [&](double u, double v) {
    return *viewpoint->camera.project(viewpoint->camera_from_projector * sheet.in_projector(u, v));
  };
  const Vec2 right = seen(1, 0) - seen(0, 0), down = seen(0, 1) - seen(0, 0);
  EXPECT_NEAR(right.norm() / down.norm(), 0.2 / 0.15, 1e-6);
  EXPECT_NEAR(right.normalized().dot(down.normalized()), 0, 1e-9);
  EXPECT_NEAR(down.x() / down.y(), 0, 1e-9);  // upright
  EXPECT_GT(down.y(), 0);
  for (const double v : {0.03, 0.47, 0.53, 0.97})
    for (const double u : {0.03, 0.47, 0.53, 0.97}) {
      const Vec2 p = seen(u, v);
      const int x = int(std::lround(p.x())), y = int(std::lround(p.y()));
      EXPECT_EQ(view.at(x, y, 0) > 128, (u < 0.5) == (v < 0.5)) << u << " " << v;
      EXPECT_EQ(view.at(x, y, 1) > 128, u > 0.5) << u << " " << v;
      EXPECT_EQ(view.at(x, y, 2) > 128, v > 0.5) << u << " " << v;
    }
}

TEST(Preview, HasNoViewpointWithoutAPlane) {
  const ImageU8 content(4, 4, 1, 9);
  Scene scene;
  scene.items.push_back({PlacedPixels{}, content});
  EXPECT_FALSE(render::facing_viewpoint(scene));
}

}  // namespace
}  // namespace procam
