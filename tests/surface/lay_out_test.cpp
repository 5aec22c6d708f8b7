/// Fit, crop, outline and holes: where a picture's corners come to lie, and what the frame shows of them.
#include "procam/surface/lay_out.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "content_aspect.hpp"
#include "procam/core/geometry/homography.hpp"
#include "render/rooms.hpp"

namespace procam {
namespace {

using surface::content_aspect;
using surface::LaidOut;
using surface::lay_out;

Surface laid_as(Fit fit) {
  Surface surface;
  surface.name = "wall";
  surface.layout.fit = fit;
  return surface;
}

PlacedPlane plane_of(double width, double height) {
  PlacedPlane plane;
  plane.plane_from_content << width, 0, 0.3, 0, height, -0.2, 0, 0, 1;
  return plane;
}

Vec2 corner(const LaidOut& laid, double u, double v) {
  return (std::get<PlacedPlane>(laid.placement).plane_from_content * Vec3(u, v, 1)).hnormalized();
}

TEST(ContentAspect, IsThatOfTheSurface) {
  EXPECT_NEAR(*content_aspect(plane_of(1.6, 0.5)), 3.2, 1e-12);
  PlacedPixels pixels;
  pixels.pixel_from_content << 300, 0, 40, 0, 400, 7, 0, 0, 1;
  EXPECT_NEAR(*content_aspect(pixels), 0.75, 1e-12);
  CylinderSurface column;
  column.radius = 0.3;
  column.left = -40 * kDegree;
  column.right = 75 * kDegree;
  column.top = -0.2;
  column.bottom = 0.7;
  Surface surface;
  surface.geometry = column;
  EXPECT_NEAR(*content_aspect(PlacedMesh{mesh_of(surface), Pose()}), 0.3 * 115 * kDegree / 0.9, 1e-3);
  PlacedPlane horizon;
  horizon.plane_from_content << 1, 0, 0, 0, 1, 0, -2, 0, 1;  // u = 1/2 lies on it
  EXPECT_FALSE(content_aspect(horizon));
}

TEST(LayOut, StretchesCornersOntoCorners) {
  const LaidOut laid = lay_out(plane_of(1.6, 0.5), laid_as(Fit::kStretch), {64, 48});
  EXPECT_EQ(laid.size, (ImageSize{64, 48}));
  EXPECT_NEAR((corner(laid, 1, 1) - Vec2(1.9, 0.3)).norm(), 0, 1e-12);
  EXPECT_TRUE(laid.mask.empty());
}

TEST(LayOut, ContainsAllOfThePictureInTheMiddle) {
  const LaidOut wide = lay_out(plane_of(1.6, 0.5), laid_as(Fit::kContain), {64, 48});  // bars left and right
  EXPECT_EQ(wide.size, (ImageSize{64, 48}));
  EXPECT_NEAR((corner(wide, 0, 0) - Vec2(0.3 + 0.8 - 1.0 / 3, -0.2)).norm(), 0, 1e-12);
  EXPECT_NEAR((corner(wide, 1, 1) - Vec2(0.3 + 0.8 + 1.0 / 3, 0.3)).norm(), 0, 1e-12);
  const LaidOut high = lay_out(plane_of(0.5, 1.6), laid_as(Fit::kContain), {64, 48});  // bars above and below
  EXPECT_NEAR((corner(high, 0, 0) - Vec2(0.3, -0.2 + 0.8 - 0.1875)).norm(), 0, 1e-12);
  EXPECT_NEAR((corner(high, 1, 1) - Vec2(0.8, -0.2 + 0.8 + 0.1875)).norm(), 0, 1e-12);
}

TEST(LayOut, CoversAllOfTheAreaWithTheMiddle) {
  const LaidOut wide = lay_out(plane_of(1.6, 0.5), laid_as(Fit::kCover), {640, 480});
  EXPECT_EQ(wide.size, (ImageSize{640, 200}));
  EXPECT_EQ(wide.x, 0);
  EXPECT_EQ(wide.y, 140);
  EXPECT_NEAR((corner(wide, 1, 1) - Vec2(1.9, 0.3)).norm(), 0, 1e-12);
  const LaidOut high = lay_out(plane_of(0.5, 1.6), laid_as(Fit::kCover), {640, 480});
  EXPECT_EQ(high.size, (ImageSize{150, 480}));
  EXPECT_EQ(high.x, 245);
}

TEST(LayOut, CropsFirstAndShowsThatPart) {
  Surface surface = laid_as(Fit::kStretch);
  surface.layout.crop_from = {0.25, 0.1};
  surface.layout.crop_to = {0.75, 0.95};
  ImageU8 picture(40, 20, 3);
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 40; ++x) picture.at(x, y, 1) = std::uint8_t(5 * x + y);
  const LaidOut laid = lay_out(plane_of(1.6, 0.5), surface, picture.size());
  const ViewU8 part = laid.part(picture);
  EXPECT_EQ(part.size(), (ImageSize{20, 17}));
  EXPECT_EQ(part.at(0, 0, 1), 5 * 10 + 2);
  EXPECT_EQ(part.at(19, 16, 1), 5 * 29 + 18);
  surface.layout.fit = Fit::kContain;  // of the part, 20 x 17
  const LaidOut contained = lay_out(plane_of(1.6, 0.5), surface, picture.size());
  EXPECT_NEAR((corner(contained, 1, 0) - corner(contained, 0, 0)).norm(), 0.5 * 20 / 17, 1e-12);
  surface.layout.crop_to = {0.2, 0.9};
  EXPECT_THROW(lay_out(plane_of(1, 1), surface, picture.size()), Error);
  EXPECT_THROW(lay_out(plane_of(1, 1), laid_as(Fit::kCover), {0, 3}), std::invalid_argument);
}

TEST(LayOut, AColourFillsWhateverTheFit) {
  for (const Fit fit : {Fit::kStretch, Fit::kContain, Fit::kCover}) {
    const LaidOut laid = lay_out(plane_of(1.6, 0.5), laid_as(fit), {1, 1});
    EXPECT_NEAR((corner(laid, 1, 1) - Vec2(1.9, 0.3)).norm(), 0, 1e-12);
    EXPECT_EQ(laid.size, (ImageSize{1, 1}));
  }
}

/// A plane and the same plane as triangles show the same contained picture, to the frame's pixels.
TEST(LayOut, ContainsOnMeshesAsOnPlanes) {
  const Projector projector = lopsided_projector();
  const Sheet sheet = tilted_sheet(projector, 0.9, 0.4, 1.7, 40);
  Mesh mesh;
  constexpr int kCells = 3;
  for (int j = 0; j <= kCells; ++j)
    for (int i = 0; i <= kCells; ++i) {
      const Vec2 p = sheet.plane_point(double(i) / kCells, double(j) / kCells);
      mesh.vertices.emplace_back(p.x(), p.y(), 0);
      mesh.uv.emplace_back(double(i) / kCells, double(j) / kCells);
      if (i == kCells || j == kCells) continue;
      const int a = j * (kCells + 1) + i;
      mesh.triangles.push_back({a, a + 1, a + kCells + 1});
      mesh.triangles.push_back({a + 1, a + kCells + 2, a + kCells + 1});
    }
  const PlacedMesh placed{std::make_shared<const Mesh>(mesh), sheet.placement.projector_from_surface};
  ImageU8 picture(30, 40, 1);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 30; ++x) picture.at(x, y) = std::uint8_t(100 + 3 * x + y);
  Scene plane_scene, mesh_scene;
  const LaidOut on_plane = lay_out(sheet.placement, laid_as(Fit::kContain), picture.size()),
                on_mesh = lay_out(placed, laid_as(Fit::kContain), picture.size());
  plane_scene.items.push_back({on_plane.placement, on_plane.part(picture)});
  mesh_scene.items.push_back({on_mesh.placement, on_mesh.part(picture)});
  const ImageU8 a = render::render(plane_scene, projector), b = render::render(mesh_scene, projector);
  int lit = 0, different = 0;
  for (int y = 0; y < a.height(); ++y)
    for (int x = 0; x < a.width(); ++x) {
      lit += a.at(x, y) > 0;
      different += std::abs(int(a.at(x, y)) - int(b.at(x, y))) > 3;
    }
  EXPECT_GT(lit, 60000);
  EXPECT_LT(different, 0.012 * lit) << "only at the edges, which meshes draw by 16 samples";
}

ContentShape wall_with_a_door() {
  ContentShape shape;
  shape.outline = {{0.02, 0.31}, {0.47, 0.03}, {0.97, 0.28}, {0.88, 0.96}, {0.05, 0.9}};
  shape.holes = {{{0.3, 0.4}, {0.42, 0.45}, {0.36, 0.7}}, {{0.6, 0.3}, {0.6, 0.6}, {0.8, 0.6}, {0.75, 0.4}}};
  return shape;
}

/// What a person sees of the edges: each pixel of the frame against 32 x 32 looks at the polygons themselves.
TEST(LayOut, EdgesOfAnOutlineLieWhereTheyBelong) {
  const Projector projector = lopsided_projector();
  const Sheet sheet = tilted_sheet(projector, 0.9, 0.5, 1.7, 45);
  Surface surface = laid_as(Fit::kStretch);
  surface.shape = wall_with_a_door();
  const ImageU8 white(1, 1, 1, 255);
  const LaidOut laid = lay_out(sheet.placement, surface, white.size());
  EXPECT_EQ(std::max(laid.mask.width(), laid.mask.height()), surface::kMaskSide);
  Scene scene;
  scene.items.push_back({laid.placement, white});
  scene.items[0].mask = laid.mask;
  render::RenderOptions options;
  options.linear_light = false;
  const ImageU8 frame = render::render(scene, projector, options);

  const Mat3 content_from_plane = sheet.placement.plane_from_content.inverse();
  constexpr int kLooks = 32;
  double worst = 0, sum = 0, squares = 0;
  int edges = 0;
  for (int y = 100; y < 700; y += 3)
    for (int x = 50; x < 1000; ++x) {
      if (frame.at(x, y) == frame.at(x - 1, y) && frame.at(x, y) == frame.at(x + 1, y)) continue;
      int inside = 0;
      for (int j = 0; j < kLooks; ++j)
        for (int i = 0; i < kLooks; ++i) {
          const auto p =
              sheet.landed(projector, Vec2(x + (i + 0.5) / kLooks - 0.5, y + (j + 0.5) / kLooks - 0.5));
          if (!p) continue;
          const Vec2 uv = (content_from_plane * p->homogeneous()).hnormalized();
          inside += in_shape(surface.shape, uv);
        }
      const double error = frame.at(x, y) / 255.0 - double(inside) / (kLooks * kLooks);
      worst = std::max(worst, std::abs(error));
      sum += error;
      squares += error * error;
      ++edges;
    }
  ASSERT_GT(edges, 1000);
  const double rms = std::sqrt(squares / edges);
  // Shares of a pixel; measured 0.120, 0.028 and 0.0001 where a pixel is 0.9 to 1.6 of the mask's.
  EXPECT_LT(worst, 0.15);
  EXPECT_LT(rms, 0.035);
  EXPECT_LT(std::abs(sum / edges), 0.001);
}

/// The mask's own pixels hold the exact area: their sum is the polygons' area.
TEST(LayOut, MasksHoldTheExactArea) {
  Surface surface = laid_as(Fit::kStretch);
  surface.shape = wall_with_a_door();
  const LaidOut laid = lay_out(plane_of(1.6, 0.9), surface, {1, 1});
  double sum = 0;
  for (int y = 0; y < laid.mask.height(); ++y)
    for (int x = 0; x < laid.mask.width(); ++x) sum += laid.mask.at(x, y) / 255.0;
  double area = std::abs(twice_area(surface.shape.outline));
  for (const Points2& hole : surface.shape.holes) area -= std::abs(twice_area(hole));
  EXPECT_NEAR(sum / laid.mask.width() / laid.mask.height(), area / 2, 2e-6);
}

TEST(LayOut, MasksFollowTheFitAndMultiplyThePolygons) {
  Surface surface = laid_as(Fit::kContain);
  auto mask = std::make_shared<ImageU8>(4, 2, 1, 255);
  for (int y = 0; y < 2; ++y) mask->at(0, y) = mask->at(1, y) = 100;  // the left half
  surface.shape.mask = mask;
  surface.shape.holes = {{{0.55, 0.1}, {0.9, 0.1}, {0.9, 0.9}, {0.55, 0.9}}};
  // 3.2 wide area, 1.6 wide picture: u from 1/4 to 3/4.
  const LaidOut laid = lay_out(plane_of(1.6, 0.5), surface, {160, 100});
  const auto at = [&](double u, double v) {  // of the area
    return int(laid.mask.at(int((u - 0.25) / 0.5 * laid.mask.width()), int(v * laid.mask.height())));
  };
  EXPECT_EQ(at(0.3, 0.5), 100);
  EXPECT_EQ(at(0.7, 0.05), 255);
  EXPECT_EQ(at(0.7, 0.5), 0);
  EXPECT_NEAR(at(0.5 + 0.04, 0.5), 202, 1);  // between the mask's texels, bilinear
}

TEST(ContentShape, FaultsAreTold) {
  const auto fault = [](Points2 outline, std::vector<Points2> holes = {}) {
    ContentShape shape;
    shape.outline = std::move(outline);
    shape.holes = std::move(holes);
    return fault_of(shape).value_or("none");
  };
  const Points2 square{{0.1, 0.1}, {0.9, 0.1}, {0.9, 0.9}, {0.1, 0.9}};
  const Points2 inner{{0.3, 0.3}, {0.5, 0.3}, {0.5, 0.5}};
  EXPECT_EQ(fault({}), "none");
  EXPECT_EQ(fault(square, {inner}), "none");
  EXPECT_EQ(fault({}, {inner}), "none");
  EXPECT_EQ(fault({{0, 0}, {1, 0}, {1, 1}, {0.5, 0.5}, {0, 1}}), "none");
  EXPECT_EQ(fault({{0, 0}, {0.5, 0}, {1, 0}, {1, 1}}), "none") << "a corner on a side is allowed";
  EXPECT_NE(fault({{0, 0}, {1, 0}}).find("2 corners"), std::string::npos);
  EXPECT_NE(fault({{0, 0}, {1, 1}, {1, 0}, {0, 1}}).find("sides 0 and 2"), std::string::npos);
  EXPECT_NE(fault({{0, 0}, {1, 0}, {0.5, 0}, {0.5, 1}}).find("turns back"), std::string::npos);
  EXPECT_NE(fault({{0, 0}, {1, 0}, {1, 1}, {0.5, 0}, {0, 1}}).find("touches"), std::string::npos);
  EXPECT_NE(fault({{0, 0}, {0.5, 0.5}, {1, 1}}).find("turns back"), std::string::npos);
  EXPECT_NE(fault({{0, 0}, {0, 0}, {1, 1}}).find("twice"), std::string::npos);
  EXPECT_NE(fault({{0, 0}, {1.5, 0}, {1, 1}}).find("outside 0 .. 1"), std::string::npos);
  EXPECT_NE(fault({{0, 0}, {std::nan(""), 0}, {1, 1}}).find("outside 0 .. 1"), std::string::npos);
  EXPECT_NE(fault(square, {{{0, 0}, {0.05, 0}, {0.05, 0.05}}}).find("hole 0 lies outside"),
            std::string::npos);
  EXPECT_NE(fault(square, {{{0.5, 0.5}, {1, 0.5}, {0.5, 0.6}}}).find("meets the outline"), std::string::npos);
  EXPECT_NE(fault(square, {inner, {{0.4, 0.2}, {0.45, 0.8}, {0.4, 0.8}}}).find("hole 1 meets hole 0"),
            std::string::npos);
  EXPECT_NE(fault(square, {square, inner}).find("meets"), std::string::npos);
  EXPECT_NE(fault({}, {square, inner}).find("hole 1 and hole 0 lie in each other"), std::string::npos);
  EXPECT_NE(fault({}, {inner, square}).find("lie in each other"), std::string::npos);
  Points2 many;
  for (int i = 0; i < 5000; ++i)
    many.emplace_back(0.5 + 0.4 * std::cos(i * 1e-3), 0.5 + 0.4 * std::sin(i * 1e-3));
  EXPECT_NE(fault(many).find("4096"), std::string::npos);
}

}  // namespace
}  // namespace procam
