#include "procam/surface/solve.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace procam {
namespace {

using surface::solve_surfaces;

RigProjector lopsided() {
  RigProjector projector;
  projector.name = "beamer";
  projector.projector = {
      Camera{{1024, 768}, {1880, 1846, 497.3, 851.6, 3.1}, BrownConrady{{-0.2, 0.03, 0.0011, -0.0007, 0}}}};
  projector.rig_from_projector =
      Pose(Eigen::Quaterniond(0.97, 0.1, -0.17, 0.05).normalized(), Vec3(0.2, -0.05, 0.11));
  return projector;
}

/// A sheet in front of the picture's middle, tilted about an oblique axis.
Pose projector_from_sheet() {
  return Pose(Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vec3(0.4, 1, 0.2).normalized())),
              Vec3(-0.02, -0.42, 1.6));
}

const Mat3 kPlaneFromContent = [] {
  Mat3 m;
  m << 0.21, 0.02, -0.09, -0.01, 0.19, -0.1, 0.15, -0.08, 1;
  return m;
}();

PlanarSurface planar(const Pose& frame_from_surface, const std::string& frame, int pairs = 9) {
  PlanarSurface result;
  result.frame = frame;
  result.frame_from_surface = frame_from_surface;
  for (int i = 0; i < pairs; ++i) {
    const Vec2 uv = pairs == 4 ? Vec2(i & 1, (i >> 1) & 1) : Vec2(0.05 + 0.4 * (i % 3), 0.1 + 0.37 * (i / 3));
    result.content.push_back(uv);
    result.points.push_back((kPlaneFromContent * Vec3(uv.x(), uv.y(), 1)).hnormalized());
  }
  return result;
}

Surface named(const std::string& name, SurfaceGeometry geometry) {
  Surface surface;
  surface.name = name;
  surface.geometry = std::move(geometry);
  return surface;
}

std::string message_of(const SurfaceSet& set, ErrorKind kind) {
  try {
    solve_surfaces(set, lopsided());
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "solved";
  return {};
}

TEST(SolveSurfaces, FindsTheSamePlacementFromEveryFrame) {
  const RigProjector projector = lopsided();
  const Pose projector_from_world(Eigen::Quaterniond(0.8, -0.3, 0.2, 0.4).normalized(), Vec3(1.2, -3, 0.7));
  SurfaceSet set;
  set.surfaces.push_back(named("a", planar(projector_from_sheet(), "projector")));
  set.surfaces.push_back(named("b", planar(projector.rig_from_projector * projector_from_sheet(), "rig")));
  set.surfaces.push_back(
      named("c", planar(projector_from_world.inverse() * projector_from_sheet(), "world", 4)));
  const SolvedSurfaceSet solved = solve_surfaces(set, projector, projector_from_world);
  EXPECT_EQ(solved.projector, "beamer");
  EXPECT_TRUE(solved.projector_from_world.has_value());
  ASSERT_EQ(solved.surfaces.size(), 3u);
  for (const SolvedSurface& s : solved.surfaces) {
    const PlacedPlane& placed = std::get<PlacedPlane>(s.placement);
    EXPECT_NEAR((placed.projector_from_surface.matrix34() - projector_from_sheet().matrix34()).norm(), 0,
                1e-12);
    EXPECT_NEAR((placed.plane_from_content - kPlaneFromContent / kPlaneFromContent.norm()).norm(), 0, 1e-9);
    EXPECT_LT(s.rms, 1e-9);
    EXPECT_TRUE(s.diagnostics.items.empty()) << s.diagnostics.items[0].message;
    EXPECT_EQ(s.visibility.covered_share, 1);
    EXPECT_TRUE(s.visibility.facing);
    ASSERT_TRUE(s.corners_px.has_value());
    const Vec2 p = (kPlaneFromContent * Vec3(1, 1, 1)).hnormalized();
    const Vec2 corner = *projector.projector.project(projector_from_sheet() * Vec3(p.x(), p.y(), 0));
    EXPECT_LT(((*s.corners_px)[2] - corner).norm(), 1e-6);
  }
  set.surfaces.pop_back();
  EXPECT_FALSE(solve_surfaces(set, projector).projector_from_world.has_value());
}

// A pixel of angle 1/f at distance z, seen at incidence a: z / (f cos^2...) along the tilt; checked on a
// sheet across the axis of a pinhole, where it is z / fx and z / fy, and tilted by 60 degrees about x on the
// axis.
TEST(SolveSurfaces, MeasuresIncidenceAndMillimetresPerPixel) {
  RigProjector projector = lopsided();
  projector.projector.inverse_camera.distortion = NoDistortion{};
  projector.projector.inverse_camera.intrinsics = {1800, 1500, 500, 380, 0};
  PlanarSurface tiny = planar(Pose(Eigen::Quaterniond::Identity(), Vec3(0, 0, 1.5)), "projector", 4);
  for (std::size_t i = 0; i < 4; ++i) tiny.points[i] = 1e-3 * (tiny.content[i] - Vec2(0.5, 0.5));
  SurfaceSet set;
  set.surfaces.push_back(named("across", tiny));
  tiny.frame_from_surface.rotation = Eigen::AngleAxisd(std::acos(0.5), Vec3::UnitX());
  set.surfaces.push_back(named("tilted", tiny));
  const SolvedSurfaceSet solved = solve_surfaces(set, projector);
  EXPECT_NEAR(solved.surfaces[0].visibility.incidence_deg, 0, 1e-3);
  EXPECT_NEAR(solved.surfaces[0].visibility.mm_per_pixel_min, 1500.0 / 1800, 1e-3);
  EXPECT_NEAR(solved.surfaces[0].visibility.mm_per_pixel_max, 1500.0 / 1500, 1e-3);
  EXPECT_NEAR(solved.surfaces[1].visibility.incidence_deg, 60, 1e-3);
  EXPECT_NEAR(solved.surfaces[1].visibility.mm_per_pixel_min, 1500.0 / 1800, 2e-3);
  EXPECT_NEAR(solved.surfaces[1].visibility.mm_per_pixel_max, 2 * 1500.0 / 1500, 4e-3);
}

TEST(SolveSurfaces, SaysHowMuchFallsInsideThePicture) {
  PixelSurface half;
  half.content = {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)};
  half.pixels = {Vec2(823.5, 99.5), Vec2(1223.5, 99.5), Vec2(1223.5, 299.5), Vec2(823.5, 299.5)};
  SurfaceSet set;
  set.surfaces.push_back(named("half", half));
  for (Vec2& pixel : half.pixels) pixel.x() += 500;
  set.surfaces.push_back(named("out", half));
  const SolvedSurfaceSet solved = solve_surfaces(set, lopsided());
  EXPECT_NEAR(solved.surfaces[0].visibility.covered_share, 0.5, 0.01);
  EXPECT_TRUE(solved.surfaces[0].diagnostics.find("partly_outside"));
  EXPECT_EQ(solved.surfaces[1].visibility.covered_share, 0);
  EXPECT_TRUE(solved.surfaces[1].diagnostics.find("outside_picture"));
  EXPECT_FALSE(surface::diagnostics_of(solved).failed());
}

/// Millimetres in a file of metres.
TEST(SolveSurfaces, NamesTheUnitsOfASurfaceThatIsTooFarAway) {
  PlanarSurface wall;
  wall.frame = "projector";
  wall.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (const double scale : {1.0, 1000.0}) {
    wall.frame_from_surface = Pose(Mat3::Identity(), scale * Vec3(-0.3, -0.2, 2.1));
    wall.points = {{0, 0}, {0.7 * scale, 0}, {0.7 * scale, 0.4 * scale}, {0, 0.4 * scale}};
    SurfaceSet set;
    set.surfaces.push_back(named("wall", wall));
    const SolvedSurfaceSet solved = solve_surfaces(set, lopsided());
    const Diagnostic* units = solved.surfaces[0].diagnostics.find("implausible_units");
    EXPECT_EQ(units != nullptr, scale > 1);
    if (units != nullptr) EXPECT_NE(units->message.find("21"), std::string::npos) << units->message;
  }
}

/// The points alone are in millimetres, their frame is not.
TEST(SolveSurfaces, NamesTheUnitsOfASurfaceThatIsTooWide) {
  PlanarSurface wall = planar(projector_from_sheet(), "projector", 4);
  for (Vec2& point : wall.points) point *= 1000;
  SurfaceSet set;
  set.surfaces.push_back(named("wall", wall));
  const SolvedSurfaceSet solved = solve_surfaces(set, lopsided());
  const Diagnostic* units = solved.surfaces[0].diagnostics.find("implausible_units");
  ASSERT_TRUE(units);
  EXPECT_NE(units->message.find("its points seem to be in millimetres"), std::string::npos) << units->message;
}

/// Of all the ways to give four corners only those that mirror are warned of; a turned content is none of them.
TEST(SolveSurfaces, WarnsOfAMirroredContent) {
  const auto is_mirrored = [](const Surface& surface) {
    SurfaceSet set;
    set.surfaces.push_back(surface);
    const SolvedSurface solved = solve_surfaces(set, lopsided()).surfaces[0];
    EXPECT_FALSE(solved.diagnostics.failed());
    return solved.diagnostics.find("mirrored") != nullptr;
  };
  PlanarSurface sheet = planar(projector_from_sheet(), "projector", 4);
  PixelSurface pixel;
  pixel.content = sheet.content;
  pixel.pixels = {{311.5, 99.5}, {723.5, 119.5}, {290.5, 299.5}, {745.5, 344.5}};
  EXPECT_FALSE(is_mirrored(named("sheet", sheet)));
  EXPECT_FALSE(is_mirrored(named("pixel", pixel)));

  PlanarSurface upwards = sheet, turned = sheet, from_behind = sheet;
  for (Vec2& point : upwards.points) point.y() *= -1;
  EXPECT_TRUE(is_mirrored(named("upwards", upwards)));
  for (Vec2& uv : turned.content) uv = Vec2(1, 1) - uv;
  EXPECT_FALSE(is_mirrored(named("turned", turned)));
  // z out of the wall and y up: a reader in front sees it the right way round.
  from_behind.points = upwards.points;
  from_behind.frame_from_surface.rotation =
      from_behind.frame_from_surface.rotation * Eigen::AngleAxisd(std::acos(-1.0), Vec3::UnitX());
  EXPECT_FALSE(is_mirrored(named("from behind", from_behind)));

  for (Vec2& uv : sheet.content) uv.x() = 1 - uv.x();
  for (Vec2& uv : pixel.content) uv.x() = 1 - uv.x();
  EXPECT_TRUE(is_mirrored(named("sheet", sheet)));
  EXPECT_TRUE(is_mirrored(named("pixel", pixel)));

  PixelSurface curved;
  curved.shape = PixelShape::kGrid;
  curved.columns = curved.rows = 2;
  curved.pixels = {{311.5, 99.5}, {723.5, 119.5}, {290.5, 299.5}, {745.5, 344.5}};
  EXPECT_FALSE(is_mirrored(named("curved", curved)));
  std::swap(curved.pixels[0], curved.pixels[1]);
  std::swap(curved.pixels[2], curved.pixels[3]);
  EXPECT_TRUE(is_mirrored(named("curved", curved)));
}

/// Content in pixels instead of 0..1, and projector pixels as fractions: a dot.
TEST(SolveSurfaces, FailsADotAndNamesTheUnits) {
  const auto too_small = [](const Surface& surface) -> std::string {
    SurfaceSet set;
    set.surfaces.push_back(surface);
    const SolvedSurfaceSet solved = solve_surfaces(set, lopsided());
    const Diagnostic* found = solved.surfaces[0].diagnostics.find("too_small");
    EXPECT_EQ(surface::diagnostics_of(solved).failed(), found != nullptr);
    return found != nullptr ? found->message : "";
  };
  PlanarSurface sheet = planar(projector_from_sheet(), "projector", 4);
  PixelSurface pixel;
  pixel.content = sheet.content;
  pixel.pixels = {{311.5, 99.5}, {723.5, 119.5}, {290.5, 299.5}, {745.5, 344.5}};
  EXPECT_EQ(too_small(named("sheet", sheet)), "");
  EXPECT_EQ(too_small(named("pixel", pixel)), "");

  PlanarSurface in_pixels = sheet;
  for (Vec2& uv : in_pixels.content) uv = uv.cwiseProduct(Vec2(1920, 1080));
  EXPECT_NE(too_small(named("sheet", in_pixels)).find("content points reach 1920"), std::string::npos);
  // Of a small content on a large wall more than a dot remains.
  for (Vec2& uv : in_pixels.content) uv = uv.cwiseProduct(Vec2(32 / 1920.0, 24 / 1080.0));
  EXPECT_EQ(too_small(named("sheet", in_pixels)), "");
  SurfaceSet set;
  set.surfaces.push_back(named("sheet", in_pixels));
  EXPECT_TRUE(solve_surfaces(set, lopsided()).surfaces[0].diagnostics.find("implausible_units"));

  for (Vec2& p : pixel.pixels) p = p.cwiseQuotient(Vec2(1024, 768));
  EXPECT_NE(too_small(named("pixel", pixel)).find("divided by the frame's size"), std::string::npos);
  for (Vec2& point : sheet.points) point *= 1e-3;
  EXPECT_NE(too_small(named("sheet", sheet)).find("at_m in metres"), std::string::npos);
}

TEST(SolveSurfaces, FailsTheGateOfASurfaceThatNoLightCanReachAndSolvesTheOthers) {
  Pose behind = projector_from_sheet();
  behind.translation *= -1;
  Pose edge_on(Eigen::Quaterniond(Eigen::AngleAxisd(std::acos(0.0), Vec3::UnitY())), Vec3(0, -0.3, 1.2));
  Pose turned = projector_from_sheet();
  turned.rotation = turned.rotation * Eigen::AngleAxisd(std::acos(-1.0), Vec3::UnitX());
  SurfaceSet set;
  set.surfaces.push_back(named("behind", planar(behind, "projector")));
  set.surfaces.push_back(named("edge", planar(edge_on, "projector")));
  set.surfaces.push_back(named("turned", planar(turned, "projector")));
  set.surfaces.push_back(named("good", planar(projector_from_sheet(), "projector")));
  const SolvedSurfaceSet solved = solve_surfaces(set, lopsided());
  EXPECT_TRUE(solved.surfaces[0].diagnostics.find("behind_projector"));
  EXPECT_TRUE(solved.surfaces[0].diagnostics.failed());
  EXPECT_TRUE(solved.surfaces[1].diagnostics.find("edge_on"));
  EXPECT_FALSE(solved.surfaces[0].corners_px || solved.surfaces[1].corners_px);
  EXPECT_FALSE(solved.surfaces[2].visibility.facing);
  EXPECT_TRUE(solved.surfaces[2].diagnostics.find("seen_from_behind"));
  EXPECT_TRUE(solved.surfaces[3].diagnostics.items.empty());
  EXPECT_EQ(surface::diagnostics_of(solved).items[0].message.find("surface 'behind': "), 0u);
}

TEST(SolveSurfaces, NamesTheSurfaceAndTheReasonWhenItRefuses) {
  const auto with = [](PlanarSurface geometry) {
    SurfaceSet set;
    set.surfaces.push_back(named("good", planar(projector_from_sheet(), "projector")));
    set.surfaces.push_back(named("wall", std::move(geometry)));
    return set;
  };
  const PlanarSurface good = planar(projector_from_sheet(), "projector", 4);
  PlanarSurface three = good, collinear = good, lists = good, twisted = good;
  three.content.pop_back();
  three.points.pop_back();
  collinear.points[3] = 0.5 * (collinear.points[0] + collinear.points[1]);
  lists.points.pop_back();
  std::swap(twisted.points[0], twisted.points[1]);
  for (const auto& [geometry, kind, reason] :
       {std::tuple(three, ErrorKind::kNotEnoughData, "3 pairs"),
        std::tuple(collinear, ErrorKind::kDegenerate, "line"),
        std::tuple(lists, ErrorKind::kInput, "3 destination"),
        std::tuple(twisted, ErrorKind::kDegenerate, "horizon"),
        std::tuple(planar(Pose(), "world"), ErrorKind::kInput, "--pose"),
        std::tuple(planar(Pose(), "moon"), ErrorKind::kInput, "unknown frame 'moon'")}) {
    const std::string message = message_of(with(geometry), kind);
    EXPECT_NE(message.find("'wall'"), std::string::npos) << message;
    EXPECT_NE(message.find(reason), std::string::npos) << message;
  }
  SurfaceSet twice = with(good);
  twice.surfaces[0].name = "wall";
  EXPECT_NE(message_of(twice, ErrorKind::kInput).find("two surfaces"), std::string::npos);
  SurfaceSet weighted = with(good);
  weighted.surfaces[1].weights = {1, 1};
  EXPECT_NE(message_of(weighted, ErrorKind::kInput).find("weights"), std::string::npos);
}

TEST(SolveSurfaces, NamesThePairThatIsOutOfLine) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.4e-3);
  PlanarSurface measured = planar(projector_from_sheet(), "projector");
  for (Vec2& p : measured.points) p += Vec2{noise(random), noise(random)};
  measured.points[4] += Vec2(0.012, -0.005);
  SurfaceSet set;
  set.surfaces.push_back(named("wall", measured));
  const SolvedSurfaceSet solved = solve_surfaces(set, lopsided());
  const Diagnostic* found = solved.surfaces[0].diagnostics.find("outlying_pair");
  ASSERT_TRUE(found);
  EXPECT_EQ(found->message.find("pair 4 lies 1"), 0u) << found->message;  // some 13 mm
  EXPECT_GT(solved.surfaces[0].rms, 1e-3);
}

/// Of three pairs in a line any one explains a shift along it. All three are named, the culprit among them.
TEST(SolveSurfaces, NamesAllPairsThatMayBeOutOfLine) {
  PlanarSurface measured;
  measured.frame = "projector";
  measured.frame_from_surface = projector_from_sheet();
  for (const double v : {0.0, 1.0})
    for (const double u : {0.0, 0.4, 1.0}) {
      measured.content.push_back(Vec2(u, v));
      measured.points.push_back(Vec2(0.31 * u - 0.1, 0.22 * v - 0.09));
    }
  const auto remark = [&](std::size_t pair, const Vec2& by) -> std::string {
    PlanarSurface moved = measured;
    moved.points[pair] += by;
    SurfaceSet set;
    set.surfaces.push_back(named("wall", moved));
    const SolvedSurface solved = solve_surfaces(set, lopsided()).surfaces[0];
    const Diagnostic* found = solved.diagnostics.find("outlying_pair");
    return found != nullptr ? found->message : "";
  };
  EXPECT_EQ(remark(4, {0.007, -0.02}).find("pair 4 lies 21.2 mm from where"), 0u)
      << remark(4, {0.007, -0.02});
  const std::string along = remark(4, {0.02, 0});
  for (const char* part :
       {"pair 3 lies ", "pair 4 lies 20 mm", "pair 5 lies ", "(the points do not show which)"})
    EXPECT_NE(along.find(part), std::string::npos) << along;
  EXPECT_EQ(along.find("pair 1"), std::string::npos) << along;
  EXPECT_EQ(remark(4, {0, 0}), "");
}

// At 1e-3 a surface (Bonferroni's bound, so at most that), 1000 surfaces give more than 6 alarms with a
// chance below 1e-4.
TEST(SolveSurfaces, SeldomCallsOutAGoodPair) {
  std::mt19937 random(11);
  std::normal_distribution<double> noise(0, 0.8e-3);
  int alarms = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    PlanarSurface measured = planar(projector_from_sheet(), "projector", 6 + trial % 4);
    for (Vec2& p : measured.points) p += Vec2{noise(random), noise(random)};
    Surface wall = named("wall", measured);
    surface::SolveOptions options;
    SurfaceSet set;
    set.surfaces.push_back(wall);
    alarms += solve_surfaces(set, lopsided(), std::nullopt, options)
                  .surfaces[0]
                  .diagnostics.find("outlying_pair") != nullptr;
  }
  EXPECT_LE(alarms, 6);
}

/// Half of it lies beyond the picture; an outline or a mask over the other half is reached as a whole.
TEST(SolveSurfaces, CountsOnlyWhatTheOutlineAndTheMaskShow) {
  PixelSurface half;
  half.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  half.pixels = {{511.5, 100}, {1535.5, 100}, {1535.5, 500}, {511.5, 500}};
  const auto share = [&](const ContentShape& shape) {
    SurfaceSet set;
    set.surfaces.push_back(named("half", half));
    set.surfaces[0].shape = shape;
    return solve_surfaces(set, lopsided()).surfaces[0].visibility.covered_share;
  };
  ContentShape shape;
  EXPECT_NEAR(share(shape), 0.5, 0.01);
  shape.outline = {{0.1, 0.1}, {0.49, 0.2}, {0.3, 0.9}};
  EXPECT_EQ(share(shape), 1);
  shape.outline.clear();
  shape.holes = {{{0.0, 0.0}, {0.5, 0.0}, {0.5, 0.5}, {0.0, 0.5}}};
  EXPECT_NEAR(share(shape), 1.0 / 3, 0.02);
  shape.holes.clear();
  auto mask = std::make_shared<ImageU8>(4, 1, 1, 51);  // a fifth on the right
  mask->at(0, 0) = mask->at(1, 0) = 255;
  shape.mask = mask;
  EXPECT_NEAR(share(shape), 5.0 / 6, 0.01);
  shape.holes = {{{0.3, 0.3}, {0.5, 0.5}, {0.3, 0.5}, {0.5, 0.3}}};
  EXPECT_THROW(share(shape), Error);
}

}  // namespace
}  // namespace procam
