/// Grids and Bezier patches in projector pixels: solved, drawn through any lens where their points are, and refused.
#include <gtest/gtest.h>

#include <cmath>

#include "procam/core/geometry/se3.hpp"
#include "procam/render/cpu.hpp"
#include "procam/surface/lay_out.hpp"
#include "procam/surface/solve.hpp"
#include "procam/surface/warp.hpp"
#include "support/expect_error.hpp"

namespace procam::surface {
namespace {

RigProjector lamp_with(Distortion distortion) {
  RigProjector projector;
  projector.name = "lamp";
  projector.projector = Projector{Camera{{160, 120}, {205, 193, 71.3, 131.2, 0.7}, distortion}};
  projector.rig_from_projector = Pose(so3_exp(Vec3(0.1, 0.2, -0.3)), Vec3(0.4, 0.1, -0.2));
  return projector;
}
const Distortion kBentLens = BrownConrady{{-0.2, 0.03, 0.0011, -0.0007, 0}};

/// Bulges to the right and sags; one point is outside the frame.
PixelSurface curtain_in_pixels(PixelShape shape) {
  PixelSurface surface;
  surface.shape = shape;
  surface.columns = 3;
  surface.rows = 4;
  surface.pixels = {{12, 9},  {71, 20.5}, {131, 5},  {20, 37}, {90, 44},  {141, 30},
                    {17, 66}, {84, 80},   {150, 61}, {-8, 99}, {66, 113}, {128, 101}};
  return surface;
}

SolvedSurfaceSet solve_curtain(const PixelSurface& surface, const RigProjector& projector) {
  return solve_surfaces({{{"curtain", surface, {}, ""}}}, projector);
}

class PixelShapes : public testing::TestWithParam<PixelShape> {};
INSTANTIATE_TEST_SUITE_P(Both, PixelShapes, testing::Values(PixelShape::kGrid, PixelShape::kBezier),
                         [](const auto& shape) {
                           return shape.param == PixelShape::kGrid ? "Grid" : "Bezier";
                         });

TEST_P(PixelShapes, EachPixelShowsTheContentThatHasItsPlaceThere) {
  const PixelSurface surface = curtain_in_pixels(GetParam());
  for (const Distortion& distortion : {Distortion(NoDistortion{}), kBentLens}) {
    const RigProjector projector = lamp_with(distortion);
    const SolvedSurfaceSet set = solve_curtain(surface, projector);
    EXPECT_TRUE(diagnostics_of(set).items.size() <= 1) << "but for the part outside the frame";
    const WarpMap map = warp_map(set.surfaces[0].placement, projector.projector);
    int shown = 0;
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 160; ++x) {
        if (!map.shows(x, y)) continue;
        ++shown;
        EXPECT_LT((surface.point(map.at(x, y)) - Vec2(x, y)).norm(), 2 * kPixelTolerance) << x << ", " << y;
      }
    EXPECT_GT(shown, 8000);
    EXPECT_LT(shown, 13000);
    const auto& placed = std::get<PlacedPixels>(set.surfaces[0].placement);
    for (const Vec2& uv : {Vec2(0, 0), Vec2(0.25, 0.7), Vec2(1, 1), Vec2(0.5, 1.0 / 3)})
      EXPECT_LT((*pixel_at(placed, uv) - surface.point(uv)).norm(), kPixelTolerance);
    EXPECT_FALSE(pixel_at(placed, Vec2(1.01, 0.5)));
    EXPECT_LT(((*set.surfaces[0].corners_px)[3] - Vec2(-8, 99)).norm(), 1e-9);
    // A table of triangles of another program's is the same.
    const WarpGrid grid = warp_mesh(set.surfaces[0].placement, projector.projector, {});
    for (std::size_t i = 0; i < grid.mesh.content.size(); i += 7)
      EXPECT_LT((grid.mesh.pixels[i] - surface.point(grid.mesh.content[i])).norm(), 1e-9);
  }
}

/// The points of a grid are its own, a Bezier patch passes through its corners alone.
TEST(PixelShape, PassesThroughItsPoints) {
  const PixelSurface grid = curtain_in_pixels(PixelShape::kGrid),
                     patch = curtain_in_pixels(PixelShape::kBezier);
  EXPECT_LT((grid.point(Vec2(0.5, 1.0 / 3)) - Vec2(90, 44)).norm(), 1e-12);
  EXPECT_GT((patch.point(Vec2(0.5, 1.0 / 3)) - Vec2(90, 44)).norm(), 1);
  for (const PixelSurface& surface : {grid, patch}) {
    EXPECT_LT((surface.point(Vec2(1, 0)) - Vec2(131, 5)).norm(), 1e-12);
    EXPECT_LT((surface.point(Vec2(0, 1)) - Vec2(-8, 99)).norm(), 1e-12);
  }
}

/// Pixel surfaces cover what is before them in the scene, curved ones too, whatever is nearer; and the later one covers them.
TEST_P(PixelShapes, CoversWhatIsListedBefore) {
  const RigProjector projector = lamp_with(kBentLens);
  PlanarSurface near;  // nearer than the metre at which the triangles are put
  near.frame = "projector";
  near.frame_from_surface = Pose(Eigen::Quaterniond::Identity(), Vec3(-0.5, -0.6, 0.6));
  near.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  near.points = {{0, 0}, {1.2, 0}, {1.2, 1.1}, {0, 1.1}};
  PlanarSurface far = near;
  far.frame_from_surface.translation.z() = 3;
  far.frame_from_surface.translation.y() = -2.5;
  for (Vec2& point : far.points) point *= 4;
  const SolvedSurfaceSet set = solve_surfaces(
      {{{"near", near, {}, ""}, {"curtain", curtain_in_pixels(GetParam()), {}, ""}, {"far", far, {}, ""}}},
      projector);
  const auto drawn = [&](const std::vector<int>& order, const std::vector<int>& levels) {
    std::vector<ImageU8> pictures;
    for (const int level : levels) pictures.emplace_back(1, 1, 1, std::uint8_t(level));
    Scene scene;
    for (std::size_t i = 0; i < order.size(); ++i)
      scene.items.push_back({set.surfaces[std::size_t(order[i])].placement, pictures[i].view()});
    return render::render(scene, projector.projector);
  };
  const ImageU8 last = drawn({0, 1}, {90, 200});
  EXPECT_EQ(last.at(80, 60, 0), 200) << "nearer surfaces do not hide it";
  EXPECT_EQ(last.at(155, 100, 0), 90) << "beside it";
  EXPECT_EQ(drawn({1, 0}, {200, 90}).at(80, 60, 0), 90);
  EXPECT_EQ(drawn({1, 2}, {200, 50}).at(80, 60, 0), 50) << "farther surfaces cover it as well";
}

/// Of a picture that is fitted, the part beside it is cut off.
TEST_P(PixelShapes, TakesAFit) {
  const RigProjector projector = lamp_with(NoDistortion{});
  const SolvedSurface one = solve_curtain(curtain_in_pixels(GetParam()), projector).surfaces[0];
  Surface fitted = one.surface;
  fitted.layout.fit = Fit::kContain;
  const LaidOut laid = lay_out(one.placement, fitted, {400, 100});
  const auto& placed = std::get<PlacedPixels>(laid.placement);
  ASSERT_TRUE(placed.mesh);
  // Wide: the content's middle stays, its upper edge moves down.
  EXPECT_LT((*pixel_at(placed, Vec2(0.5, 0.5)) - curtain_in_pixels(GetParam()).point(Vec2(0.5, 0.5))).norm(),
            0.2);
  EXPECT_GT(pixel_at(placed, Vec2(0.5, 0.01))->y(),
            curtain_in_pixels(GetParam()).point(Vec2(0.5, 0.01)).y() + 10);
}

TEST_P(PixelShapes, WhatCannotBeDrawnIsRefused) {
  const RigProjector projector = lamp_with(NoDistortion{});
  const PixelSurface good = curtain_in_pixels(GetParam());
  PixelSurface few = good, one = good, nan = good, same = good, far = good;
  few.pixels.pop_back();
  EXPECT_ERROR(solve_curtain(few, projector), kInput, "columns x rows");
  one.columns = 1;
  EXPECT_ERROR(solve_curtain(one, projector), kInput, "fewer than 2");
  nan.pixels[3].x() = std::nan("");
  EXPECT_ERROR(solve_curtain(nan, projector), kInput, "not finite");
  for (Vec2& pixel : same.pixels) pixel = Vec2(7, 8);
  EXPECT_ERROR(solve_curtain(same, projector), kInput, "'curtain'");
  far.pixels[4] = Vec2(1e12, -1e12);
  if (GetParam() == PixelShape::kBezier) EXPECT_ERROR(solve_curtain(far, projector), kInput, "so far apart");
}

}  // namespace
}  // namespace procam::surface
