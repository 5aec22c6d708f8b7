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

// A column before a wall, lit from the left: undistorted on both, and its shadow falls on the wall.
TEST(Preview, ShowsCurvedSurfacesAndTheirShadows) {
  const Projector projector = lopsided_projector(brown(-0.2));
  CylinderSurface column;
  column.radius = 0.08;
  column.left = -1.2;
  column.right = 1.2;
  column.top = -0.25;
  column.bottom = 0.25;
  const Vec3 axis = projector.emit(Vec2(512, 380))->direction;
  const Pose projector_from_column(Mat3::Identity(), 1.5 * axis);
  PlacedPlane wall;
  wall.plane_from_content << 1.2, 0, -0.6, 0, 0.9, -0.45, 0, 0, 1;
  wall.projector_from_surface = Pose(Mat3::Identity(), 1.9 * axis);
  const ImageU8 white(8, 6, 1, 255);
  ImageU8 halves(80, 60, 3, 0);  // red and blue
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 80; ++x) halves.at(x, y, x < 40 ? 0 : 2) = 255;
  Scene scene;
  scene.items = {{wall, white},
                 {PlacedMesh{mesh_of(Surface{"column", column, {}, ""}), projector_from_column}, halves}};
  const ImageU8 frame = render::render(scene, projector);
  auto viewpoint = *render::facing_viewpoint(scene);
  const Pose sideways(Mat3(Eigen::AngleAxisd(0.35, Vec3::UnitY())), Vec3(-0.5, 0, 0.1));
  viewpoint.camera_from_projector = sideways * viewpoint.camera_from_projector;
  const ImageU8 view = render::preview(scene, projector, frame, viewpoint);
  const auto seen = [&](const Vec3& in_projector, int channel) {
    const Vec2 p = *viewpoint.camera.project(viewpoint.camera_from_projector * in_projector);
    return int(view.at(int(std::lround(p.x())), int(std::lround(p.y())), channel));
  };
  const Vec3 red = projector_from_column * column.point({0.47, 0.5}),
             blue = projector_from_column * column.point({0.53, 0.5});
  EXPECT_GT(seen(red, 0), 200);
  EXPECT_LT(seen(red, 2), 110);
  EXPECT_GT(seen(blue, 2), 200);
  EXPECT_LT(seen(blue, 0), 110);
  // On the wall, behind the column along the light, and beside that.
  const Plane plane = Plane::of_xy(wall.projector_from_surface);
  const auto behind = [&](double x) {
    return *intersect(Ray{Vec3::Zero(), 1.5 * axis + Vec3(x, 0, 0)}, plane);
  };
  EXPECT_LT(seen(behind(0.07), 1), 90) << "in the column's shadow";
  EXPECT_GT(seen(behind(-0.2), 1), 200);
  EXPECT_GT(seen(behind(0.1), 1), 200);
}

// A white sheet at 60 degrees: its light falls with cos / d^2.
TEST(Preview, FallsOffWithDistanceAndAngle) {
  const Projector projector = lopsided_projector(brown(-0.2));
  const Sheet sheet = tilted_sheet(projector, 1.2, 0.5, 1.6, 60);
  const ImageU8 one(1, 1, 3, 255);
  Scene scene;
  scene.items.push_back({sheet.placement, one});
  const auto viewpoint = *render::facing_viewpoint(scene);
  const ImageU8 white = render::preview(scene, projector, ImageU8(projector.size(), 3, 255), viewpoint),
                black = render::preview(scene, projector, ImageU8(projector.size(), 3, 0), viewpoint);
  const Vec3 normal = sheet.placement.projector_from_surface.rotate(Vec3::UnitZ());
  double per_irradiance = 0;
  int compared = 0;
  for (const double u : {0.3, 0.5, 0.62}) {
    const Vec3 point = sheet.in_projector(u, 0.5);
    const Vec2 p = *viewpoint.camera.project(viewpoint.camera_from_projector * point);
    const int x = int(std::lround(p.x())), y = int(std::lround(p.y()));
    const double light = light_of(white.at(x, y, 1)) - light_of(black.at(x, y, 1));
    const double irradiance = std::abs(point.dot(normal)) / std::pow(point.norm(), 3);
    if (white.at(x, y, 1) == 255) continue;  // brighter than the picture is exposed for
    ++compared;
    if (per_irradiance > 0) {
      EXPECT_NEAR(light / irradiance / per_irradiance, 1, 0.03) << u;
    }
    per_irradiance = light / irradiance;
  }
  EXPECT_GE(compared, 2);
}

TEST(Preview, HasNoViewpointForPixelSurfacesAlone) {
  const ImageU8 content(4, 4, 1, 9);
  Scene scene;
  scene.items.push_back({PlacedPixels{}, content});
  EXPECT_FALSE(render::facing_viewpoint(scene));
}

}  // namespace
}  // namespace procam
