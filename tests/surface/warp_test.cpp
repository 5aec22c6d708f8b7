#include "procam/surface/warp.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "procam/core/geometry/homography.hpp"
#include "procam/core/geometry/se3.hpp"
#include "support/expect_error.hpp"

namespace procam::surface {
namespace {

/// Small enough to visit every pixel; skewed, off-centre, its axis below the picture.
Projector warped_projector(Distortion distortion = BrownConrady{{-0.2, 0.03, 0.0011, -0.0007, 0}}) {
  return {Camera{{128, 96}, {235, 231, 62.1, 106.4, 0.4}, distortion}};
}

/// A sheet that covers part of the picture only, tilted about an oblique axis, its content in perspective.
PlacedPlane tilted_plane() {
  PlacedPlane placed;
  placed.plane_from_content << 0.31, 0.02, -0.19, -0.01, 0.29, -0.2, 0.15, -0.08, 1;
  placed.projector_from_surface = Pose(
      Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vec3(0.4, 1, 0.2).normalized())), Vec3(0.06, -0.36, 1.6));
  return placed;
}

PlacedPixels dragged_quad() {
  PlacedPixels placed;
  placed.pixel_from_content << 91, 8, 13.3, -5, 70, 9.7, 0.11, -0.07, 1;
  return placed;
}

/// Where a pixel's light shows the plane's content, by the way that the light takes.
std::optional<Vec2> content_by_landing(const Projector& projector, const PlacedPlane& placed,
                                       const Vec2& pixel) {
  const auto point = projector.intersect(pixel, Plane::of_xy(placed.projector_from_surface));
  if (!point) return std::nullopt;
  const Vec3 on_surface = placed.projector_from_surface.inverse() * *point;
  return Homography(placed.plane_from_content).inverse().apply(on_surface.head<2>());
}

bool inside(const Vec2& uv) {
  return uv.minCoeff() >= 0 && uv.maxCoeff() <= 1;
}

TEST(WarpMap, IsWhereTheLightOfEachPixelLands) {
  const Projector projector = warped_projector();
  const WarpMap map = warp_map(tilted_plane(), projector);
  ASSERT_EQ(map.size(), projector.size());
  int shown = 0;
  for (int y = 0; y < 96; ++y)
    for (int x = 0; x < 128; ++x) {
      const auto uv = content_by_landing(projector, tilted_plane(), Vec2(x, y));
      ASSERT_EQ(map.shows(x, y), uv && inside(*uv)) << x << " " << y;
      if (!map.shows(x, y)) {
        EXPECT_EQ(map.at(x, y), Vec2::Zero());
        continue;
      }
      ++shown;
      EXPECT_LT((map.at(x, y) - *uv).norm(), 1e-7) << x << " " << y;  // the rounding of a float
    }
  EXPECT_GT(shown, 1000);
  EXPECT_LT(shown, 128 * 96 - 1000);
}

TEST(WarpMap, OfAPixelSurfaceIsItsHomographyAlone) {
  const WarpMap map = warp_map(dragged_quad(), warped_projector());
  const Homography pixel_from_content(dragged_quad().pixel_from_content);
  int shown = 0;
  for (int y = 0; y < 96; ++y)
    for (int x = 0; x < 128; ++x)
      if (map.shows(x, y)) {
        ++shown;
        EXPECT_LT((*pixel_from_content.apply(map.at(x, y)) - Vec2(x, y)).norm(), 2e-5);
      }
  EXPECT_GT(shown, 3000);
}

TEST(WarpMap, ShowsNothingBehindTheProjectorOrEdgeOn) {
  const Projector projector = warped_projector();
  PlacedPlane behind = tilted_plane();
  behind.projector_from_surface.translation = Vec3(0, 0, -1.6);
  PlacedPlane edge_on = tilted_plane();
  edge_on.projector_from_surface = Pose(so3_exp(Vec3(0, kPi / 2, 0)), Vec3(0, 0, 2));
  for (const PlacedPlane& placed : {behind, edge_on}) {
    const WarpMap map = warp_map(placed, projector);
    for (int y = 0; y < 96; ++y)
      for (int x = 0; x < 128; ++x) ASSERT_FALSE(map.shows(x, y));
  }
}

TEST(PositionMap, PointsLieOnTheSurfaceUnderTheirPixelsLight) {
  const Projector projector = warped_projector();
  const Pose world_from_projector(so3_exp(Vec3(0.31, -0.57, 0.83)), Vec3(0.42, -0.19, 1.37));
  const ImageF map = position_map(tilted_plane(), projector, world_from_projector);
  const WarpMap content = warp_map(tilted_plane(), projector);
  for (int y = 0; y < 96; ++y)
    for (int x = 0; x < 128; ++x) {
      const Vec3 point_in_world(map.at(x, y, 0), map.at(x, y, 1), map.at(x, y, 2));
      ASSERT_EQ(content.shows(x, y), point_in_world.allFinite());
      if (!content.shows(x, y)) continue;
      const Vec3 point_in_projector = world_from_projector.inverse() * point_in_world;
      EXPECT_LT((*projector.project(point_in_projector) - Vec2(x, y)).norm(), 1e-3);
      EXPECT_NEAR((tilted_plane().projector_from_surface.inverse() * point_in_projector).z(), 0, 1e-6);
    }
}

TEST(PositionMap, RefusesAPixelSurface) {
  EXPECT_ERROR(position_map(dragged_quad(), warped_projector()), kUnsupported, "not in the room");
}

/// A bulging sheet of triangles over the content, and a small one before its middle that hides some of it.
PlacedMesh bulge() {
  auto mesh = std::make_shared<Mesh>();
  for (const Vec2& uv : {Vec2(0.9, 0.1), Vec2(0.95, 0.1), Vec2(0.9, 0.3)}) {
    mesh->uv.push_back(uv);
    mesh->vertices.push_back({2 * uv.x() - 1.75, 0.7 * uv.y() - 0.12, -0.1});
  }
  mesh->triangles.push_back({0, 1, 2});
  for (int j = 0; j <= 8; ++j)
    for (int i = 0; i <= 10; ++i) {
      const double u = i / 10.0, v = j / 8.0;
      mesh->uv.push_back({u, v});
      mesh->vertices.push_back({0.5 * u - 0.2, 0.4 * v - 0.21, 0.3 * (u - 0.5) * (u - 0.4) + 0.1 * v * v});
    }
  for (int j = 0; j < 8; ++j)
    for (int i = 0; i < 10; ++i) {
      const int a = 3 + 11 * j + i;
      mesh->triangles.push_back({a, a + 12, a + 1});
      mesh->triangles.push_back({a, a + 11, a + 12});
    }
  return {mesh, tilted_plane().projector_from_surface};
}

// By the way that light takes: every triangle's plane is asked, the nearest inside its borders shows.
TEST(WarpMap, OfAMeshIsItsNearestTriangle) {
  const Projector projector = warped_projector();
  const PlacedMesh placed = bulge();
  const WarpMap map = warp_map(placed, projector);
  const ImageF positions = position_map(placed, projector);
  int shown = 0, hiding = 0;
  for (int y = 0; y < 96; ++y)
    for (int x = 0; x < 128; ++x) {
      const Vec3 direction = projector.emit(Vec2(x, y))->direction;
      double nearest = 1e9;
      Vec2 uv = Vec2::Zero();
      std::size_t which = 0;
      int met = 0;
      for (std::size_t t = 0; t < placed.mesh->triangles.size(); ++t) {
        std::array<Vec3, 3> p;
        std::array<Vec2, 3> c;
        for (std::size_t i = 0; i < 3; ++i) {
          const auto corner = std::size_t(placed.mesh->triangles[t][i]);
          p[i] = placed.projector_from_surface * placed.mesh->vertices[corner];
          c[i] = placed.mesh->uv[corner];
        }
        const Vec3 normal = Vec3((p[1] - p[0]).cross(p[2] - p[0])).normalized();
        const auto point = intersect(Ray{Vec3::Zero(), direction}, Plane{normal, -normal.dot(p[0])});
        if (!point) continue;
        Vec3 b;  // barycentric, from areas
        for (std::size_t i = 0; i < 3; ++i)
          b[Eigen::Index(i)] = Vec3(p[(i + 1) % 3] - *point).cross(p[(i + 2) % 3] - *point).dot(normal);
        b /= b.sum();
        if (b.minCoeff() < 0) continue;
        ++met;
        if (point->norm() >= nearest) continue;
        nearest = point->norm();
        uv = b[0] * c[0] + b[1] * c[1] + b[2] * c[2];
        which = t;
      }
      ASSERT_EQ(map.shows(x, y), nearest < 1e9) << x << " " << y;
      if (!map.shows(x, y)) continue;
      ++shown;
      hiding += which == 0 && met > 1;
      EXPECT_LT((map.at(x, y) - uv).norm(), 1e-6) << x << " " << y;
      EXPECT_LT(
          (Vec3(positions.at(x, y, 0), positions.at(x, y, 1), positions.at(x, y, 2)) - nearest * direction)
              .norm(),
          1e-6);
    }
  EXPECT_GT(shown, 1000);
  EXPECT_GT(hiding, 10);
}

TEST(WarpMesh, OfAMeshIsItsOwnTrianglesTheFarthestFirst) {
  const Projector projector = warped_projector();
  const WarpGrid grid = warp_mesh(bulge(), projector);
  ASSERT_GE(grid.mesh.triangles.size(), 161u);
  EXPECT_GT(grid.largest_error_px, 0);
  EXPECT_LT(grid.largest_error_px, 0.1);
  const Vec2 small = grid.mesh.content[std::size_t(grid.mesh.triangles.back()[0])];
  EXPECT_GT(small.x(), 0.85) << "the small one before all others comes last";
  for (std::size_t i = 0; i < bulge().mesh->vertices.size(); ++i) {
    const Vec3 point = bulge().projector_from_surface * bulge().mesh->vertices[i];
    EXPECT_LT((grid.mesh.pixels[i] - *projector.project(point)).norm(), 1e-12);
  }
}

// Long triangles reach far beyond the picture; what is in it counts all the same.
TEST(WarpMesh, CutsLongTrianglesWhereTheyWouldErr) {
  auto strip = std::make_shared<Mesh>();
  for (const Vec2& uv : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)}) {
    strip->uv.push_back(uv);
    strip->vertices.push_back({1.5 * uv.x() - 0.5, 1.1 * uv.y() - 0.9, 0.8 * uv.x()});
  }
  strip->triangles = {{0, 1, 2}, {0, 2, 3}};
  const WarpGrid grid =
      warp_mesh(PlacedMesh{strip, Pose(Mat3(Mat3::Identity()), Vec3(0, 0, 1.7))}, warped_projector());
  EXPECT_GT(grid.mesh.triangles.size(), 50u);
  EXPECT_GT(grid.largest_error_px, 0.001);
  EXPECT_LT(grid.largest_error_px, 0.2);
  double area = 0;
  for (const auto& [a, b, c] : grid.mesh.triangles) {
    const Vec2 s = grid.mesh.content[std::size_t(b)] - grid.mesh.content[std::size_t(a)];
    const Vec2 t = grid.mesh.content[std::size_t(c)] - grid.mesh.content[std::size_t(a)];
    area += 0.5 * std::abs(s.x() * t.y() - s.y() * t.x());
  }
  EXPECT_NEAR(area, 1, 1e-9);
}

TEST(WarpMesh, ItsCornersAreLitByTheirPixels) {
  const Projector projector = warped_projector();
  const WarpMesh mesh = warp_mesh(tilted_plane(), projector, {7, 5}).mesh;
  ASSERT_EQ(mesh.content.size(), 8u * 6u);
  ASSERT_EQ(mesh.triangles.size(), 2u * 7u * 5u);
  EXPECT_EQ(mesh.projector, projector.size());
  for (std::size_t i = 0; i < mesh.content.size(); ++i) {
    const auto uv = content_by_landing(projector, tilted_plane(), mesh.pixels[i]);
    ASSERT_TRUE(uv);
    EXPECT_LT((*uv - mesh.content[i]).norm(), 1e-9);
  }
}

TEST(WarpMesh, TrianglesCoverTheContentOnceCounterClockwiseWithYUp) {
  const WarpMesh mesh = warp_mesh(dragged_quad(), warped_projector(), {7, 5}).mesh;
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec2 s = mesh.content[std::size_t(b)] - mesh.content[std::size_t(a)];
    const Vec2 t = mesh.content[std::size_t(c)] - mesh.content[std::size_t(a)];
    const double turned = -(s.x() * t.y() - s.y() * t.x()) / 2;  // content's v runs down
    EXPECT_GT(turned, 0);
    area += turned;
  }
  EXPECT_NEAR(area, 1, 1e-12);
}

TEST(WarpMesh, LeavesOutWhatNoLightReaches) {
  PlacedPlane half_behind = tilted_plane();
  half_behind.projector_from_surface = Pose(so3_exp(Vec3(0, 1.45, 0)), Vec3(0.03, 0.1, 0.02));
  const WarpMesh mesh = warp_mesh(half_behind, warped_projector(NoDistortion{}), {12, 9}).mesh;
  EXPECT_GT(mesh.triangles.size(), 0u);
  EXPECT_LT(mesh.triangles.size(), 2u * 12u * 9u);
  for (const auto& triangle : mesh.triangles)
    for (const int corner : triangle) ASSERT_LT(std::size_t(corner), mesh.pixels.size());
}

TEST(WarpMesh, ErrorFallsWithTheSquareOfTheCells) {
  const Projector projector = warped_projector();
  const auto error_of = [&](MeshGrid grid) {
    return warp_mesh(tilted_plane(), projector, grid).largest_error_px;
  };
  const double coarse = error_of({8, 6}), fine = error_of({32, 24});
  EXPECT_GT(coarse, 0.01);
  EXPECT_NEAR(coarse / fine, 16, 3);
}

TEST(WarpMesh, RefusesAnEmptyOrAbsurdGrid) {
  for (const MeshGrid grid : {MeshGrid{0, 4}, MeshGrid{4, -1}, MeshGrid{5000, 4}})
    EXPECT_THROW(warp_mesh(dragged_quad(), warped_projector(), grid), std::invalid_argument);
}

// A small sheet before the large one, a poster on that, a hole, and a dragged quad between them in the list.
TEST(NearestSurfaces, AreTheNearestThatAreThere) {
  const Projector projector = warped_projector();
  const auto solved = [](const char* name, const Placement& placement) {
    SolvedSurface one;
    one.surface.name = name;
    one.placement = placement;
    return one;
  };
  PlacedPlane poster = tilted_plane(), near = tilted_plane();
  poster.plane_from_content.leftCols<2>() *= 0.4;
  near.projector_from_surface.translation *= 0.8;
  near.plane_from_content.leftCols<2>() *= 0.3;
  SolvedSurface holed = solved("near", near);
  holed.surface.shape.holes = {Points2{{0.2, 0.3}, {0.9, 0.3}, {0.9, 0.8}, {0.2, 0.8}}};
  SolvedSurfaceSet set;
  set.surfaces = {holed, solved("wall", tilted_plane()), solved("poster", poster)};
  const auto expected = [&](bool quad_hides_all, int x, int y) {
    const auto covered = [&](const PlacedPlane& placed) {
      const auto uv = content_by_landing(projector, placed, Vec2(x, y));
      return uv && inside(*uv) ? uv : std::nullopt;
    };
    if (quad_hides_all) return 3;
    const auto uv = covered(near);
    if (uv && in_shape(holed.surface.shape, *uv)) return 0;
    return covered(poster) ? 2 : covered(tilted_plane()) ? 1 : -1;
  };
  int of[5] = {};
  const auto compare = [&](bool with_quad) {
    const WarpMap quad = warp_map(dragged_quad(), projector);
    const auto nearest = nearest_surfaces(set, projector);
    for (int y = 0; y < 96; ++y)
      for (int x = 0; x < 128; ++x) {
        ASSERT_EQ(nearest.at(x, y), expected(with_quad && quad.shows(x, y), x, y)) << x << " " << y;
        ++of[nearest.at(x, y) + 1];
      }
  };
  compare(false);
  for (int i = 0; i < 4; ++i) EXPECT_GT(of[i], 50) << i;
  set.surfaces.push_back(solved("quad", dragged_quad()));
  compare(true);
  EXPECT_GT(of[4], 1000);
  // Listed first, it is covered by all.
  std::rotate(set.surfaces.begin(), set.surfaces.begin() + 3, set.surfaces.end());
  const auto nearest = nearest_surfaces(set, projector);
  for (int y = 0; y < 96; ++y)
    for (int x = 0; x < 128; ++x)
      if (expected(false, x, y) >= 0) {
        ASSERT_EQ(nearest.at(x, y), expected(false, x, y) + 1);
      }
}

}  // namespace
}  // namespace procam::surface
