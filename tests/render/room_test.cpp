/// Curved surfaces and meshes, and what hides what: light cast through the true projector onto the true
/// shape.
#include <gtest/gtest.h>

#include <random>

#include "procam/render/cpu.hpp"
#include "render/curved.hpp"

namespace procam {
namespace {

TEST(RenderRoom, LandsWithinATenthOfAMillimetreOnCurvedSurfaces) {
  const Discs discs;
  const Projector projector = lopsided_projector(brown(-0.19));
  for (const Shaped& shape : shaped()) {
    Scene scene;
    scene.items.push_back(
        {PlacedMesh{mesh_of(Surface{shape.name, shape.geometry, {}, ""}), shape.projector_from_surface},
         discs.picture});
    const ImageU8 frame = render::render(scene, projector);
    double worst = 0;
    for (const Vec2& uv : discs.uv) {
      const bool ball = std::holds_alternative<SphereSurface>(shape.geometry);
      const Vec3 truth = ball ? std::get<SphereSurface>(shape.geometry).point(uv)
                              : std::get<CylinderSurface>(shape.geometry).point(uv);
      const double radius = ball ? std::get<SphereSurface>(shape.geometry).radius
                                 : std::get<CylinderSurface>(shape.geometry).radius;
      const bool inside = (ball ? std::get<SphereSurface>(shape.geometry).seen_from
                                : std::get<CylinderSurface>(shape.geometry).seen_from) == SeenFrom::kInside;
      const Vec2 near = *projector.project(shape.projector_from_surface * truth);
      ASSERT_TRUE(projector.size().contains(near)) << shape.name;
      const Ray ray =
          shape.projector_from_surface.inverse() * *projector.emit(middle_of_light(frame, near, 25));
      worst = std::max(worst, 1e3 * (on_quadric(ray, radius, ball, inside) - truth).norm());
    }
    EXPECT_LT(worst, 0.1) << shape.name << ": mm, of a promised 0.2";
  }
}

TEST(RenderRoom, DrawsAPlaneOfTrianglesAsThePlane) {
  const Projector projector = lopsided_projector(brown(-0.19));
  const Sheet sheet = tilted_sheet(projector, 0.5, 0.4, 1.6, 47);
  const Discs discs;
  Mesh mesh;
  for (int j = 0; j <= 3; ++j)
    for (int i = 0; i <= 4; ++i) {
      const Vec2 p = sheet.plane_point(i / 4.0, j / 3.0);
      mesh.vertices.emplace_back(p.x(), p.y(), 0);
      mesh.uv.emplace_back(i / 4.0, j / 3.0);
    }
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 4; ++i) {
      const int a = 5 * j + i;
      mesh.triangles.push_back({a, a + 1, a + 5});
      mesh.triangles.push_back({a + 6, a + 5, a + 1});  // the other sense: both sides are seen
    }
  Scene plane, triangles;
  plane.items.push_back({sheet.placement, discs.picture});
  triangles.items.push_back(
      {PlacedMesh{std::make_shared<const Mesh>(mesh), sheet.placement.projector_from_surface},
       discs.picture});
  plane.background[1] = triangles.background[1] = 90;
  const ImageU8 one = render::render(plane, projector), other = render::render(triangles, projector);
  int different = 0, lit = 0;
  for (int y = 0; y < one.height(); ++y)
    for (int x = 0; x < one.width(); ++x) {
      lit += one.at(x, y, 0) > 0;
      // At the border 16 samples stand for the exact area, of a background with light 0.1.
      for (int c = 0; c < 3; ++c)
        different += std::abs(light_of(one.at(x, y, c)) - light_of(other.at(x, y, c))) > 0.012;
    }
  EXPECT_GT(lit, 300);
  EXPECT_EQ(different, 0);
}

/// A box round the projector, one colour: light everywhere.
TEST(RenderRoom, LeavesNoGapBetweenTrianglesNorWhereCornersLieBehind) {
  Mesh box;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> wobble(-0.2, 0.2);
  constexpr int kSide = 7;
  // A lumpy ball of quads round the origin.
  for (int j = 0; j <= kSide; ++j)
    for (int i = 0; i < 2 * kSide; ++i) {
      const double b = kPi * (double(j) / kSide - 0.5), l = kPi * i / kSide;
      const double r = 2 + wobble(random);
      box.vertices.emplace_back(r * std::cos(b) * std::sin(l), r * std::sin(b),
                                r * std::cos(b) * std::cos(l));
      box.uv.emplace_back(double(i) / (2 * kSide), double(j) / kSide);
    }
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < 2 * kSide; ++i) {
      const int a = j * 2 * kSide + i, b = j * 2 * kSide + (i + 1) % (2 * kSide), c = a + 2 * kSide,
                d = b + 2 * kSide;
      box.triangles.push_back({a, b, c});
      box.triangles.push_back({b, d, c});
    }
  const ImageU8 white(8, 6, 1, 255);
  Projector wide = lopsided_projector(brown(-0.11));
  wide.inverse_camera.intrinsics.fx = 700;
  wide.inverse_camera.intrinsics.fy = 690;
  for (const Projector& projector : {lopsided_projector(brown(-0.19)), wide}) {
    Scene scene;
    scene.items.push_back(
        {PlacedMesh{std::make_shared<const Mesh>(box), Pose(Mat3::Identity(), Vec3(0.31, -0.2, 0.4))},
         white});
    const ImageU8 frame = render::render(scene, projector);
    int dark = 0;
    for (int y = 0; y < frame.height(); ++y)
      for (int x = 0; x < frame.width(); ++x) dark += frame.at(x, y, 1) != 255;
    EXPECT_EQ(dark, 0);
  }
}

/// A white ball before a green wall.
struct BallAndWall {
  ImageU8 white{16, 12, 4, 255}, green{16, 12, 3, 0};
  Projector projector = lopsided_projector(brown(-0.19));
  Sheet wall = tilted_sheet(projector, 1.4, 1.1, 2.4, 20);
  SphereSurface ball;
  Pose projector_from_ball;
  Vec2 middle;

  BallAndWall() {
    for (int y = 0; y < 12; ++y)
      for (int x = 0; x < 16; ++x) green.at(x, y, 1) = 200;
    ball.radius = 0.15;
    ball.left = -kPi;
    ball.right = kPi;
    ball.top = kPi / 2;
    ball.bottom = -kPi / 2;
    projector_from_ball = Pose(Mat3::Identity(), 1.8 * projector.emit(Vec2(520, 371))->direction);
    middle = Vec2(520, 371);
  }
  SceneItem ball_item() const {
    return {PlacedMesh{mesh_of(Surface{"ball", ball, {}, ""}), projector_from_ball}, white};
  }
};

TEST(RenderRoom, HidesByDistanceWhateverTheOrder) {
  const BallAndWall room;
  Scene first, last;
  first.items = {room.ball_item(), {room.wall.placement, room.green}};
  last.items = {{room.wall.placement, room.green}, room.ball_item()};
  const ImageU8 one = render::render(first, room.projector), other = render::render(last, room.projector);
  EXPECT_TRUE(std::equal(one.data(), one.data() + 1024 * 768 * 3, other.data()));
  EXPECT_EQ(one.at(520, 371, 0), 255);
  // The outline is where rays touch the ball, to a tenth of a pixel: the white area is its exact share.
  double white = 0, exact = 0;
  const Vec3 centre = room.projector_from_ball.translation;
  for (int y = 150; y < 600; ++y)
    for (int x = 300; x < 750; ++x) {
      white += light_of(one.at(x, y, 0));
      const Vec3 d = room.projector.emit(Vec2(x, y))->direction.normalized();
      exact += (centre - centre.dot(d) * d).norm() < room.ball.radius;
    }
  EXPECT_NEAR(white, exact, 0.05 * std::sqrt(kPi * exact)) << "pixels; a ring of 0.025 px round the ball";
}

TEST(RenderRoom, ShowsWhatIsBehindThroughTransparentContent) {
  BallAndWall room;
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 16; ++x) room.white.at(x, y, 3) = 128;
  Scene scene;
  scene.items = {room.ball_item(), {room.wall.placement, room.green}};
  const ImageU8 frame = render::render(scene, room.projector);
  EXPECT_NEAR(light_of(frame.at(520, 371, 0)), 128 / 255.0, 0.01);
  EXPECT_NEAR(light_of(frame.at(520, 371, 1)), 128 / 255.0 + (1 - 128 / 255.0) * light_of(200), 0.01);
}

TEST(RenderRoom, TheLaterCoversWhereSurfacesLieTogetherAndPixelSurfacesCoverTheRoom) {
  const BallAndWall room;
  Sheet poster = room.wall;
  poster.placement.plane_from_content.leftCols<2>() *= 0.5;
  ImageU8 red(4, 3, 3, 0);
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 4; ++x) red.at(x, y, 0) = 255;
  Scene scene;
  scene.items = {{room.wall.placement, room.green}, {poster.placement, red}};
  const Vec2 at = *room.projector.project(poster.in_projector(0.5, 0.5));
  EXPECT_EQ(render::render(scene, room.projector).at(int(at.x()), int(at.y()), 0), 255);
  std::swap(scene.items[0], scene.items[1]);
  EXPECT_EQ(render::render(scene, room.projector).at(int(at.x()), int(at.y()), 0), 0);

  PlacedPixels sticker;
  sticker.pixel_from_content << 60, 0, 490, 0, 60, 340, 0, 0, 1;
  scene.items = {{sticker, red}, room.ball_item()};
  EXPECT_EQ(render::render(scene, room.projector).at(520, 371, 1), 255)
      << "the room covers an earlier sticker";
  std::swap(scene.items[0], scene.items[1]);
  EXPECT_EQ(render::render(scene, room.projector).at(520, 371, 1), 0);
}

TEST(RenderRoom, PlanesThatCutEachOtherShowTheNearerPart) {
  const Projector projector = lopsided_projector(brown(-0.19));
  const Sheet one = tilted_sheet(projector, 0.6, 0.5, 1.6, 40);
  Sheet other = one;
  // Turned about the content's own vertical through a place on the first.
  const Vec2 p = one.plane_point(0.5, 0.5);
  const Pose about(Mat3(Eigen::AngleAxisd(0.6, Vec3::UnitY())), Vec3::Zero());
  const Pose to(Mat3::Identity(), Vec3(p.x(), p.y(), 0)), back(Mat3::Identity(), Vec3(-p.x(), -p.y(), 0));
  other.placement.projector_from_surface = one.placement.projector_from_surface * to * about * back;
  const ImageU8 white(4, 3, 1, 255), grey(4, 3, 1, 99);
  Scene scene;
  scene.items = {{one.placement, white}, {other.placement, grey}};
  const ImageU8 frame = render::render(scene, projector);
  int whites = 0, greys = 0;
  for (int y = 0; y < frame.height(); y += 3)
    for (int x = 0; x < frame.width(); x += 3) {
      const int value = frame.at(x, y, 0);
      if (value != 255 && value != 99) continue;
      const Vec2 pixel(x, y);
      const auto distance = [&](const Sheet& sheet) {
        const auto landed = sheet.landed(projector, pixel);
        if (!landed) return 1e9;
        const Vec3 uv = sheet.placement.plane_from_content.inverse() * landed->homogeneous();
        const Vec2 at = uv.hnormalized();
        if ((at.array() < 0).any() || (at.array() > 1).any()) return 1e9;
        return projector.intersect(pixel, Plane::of_xy(sheet.placement.projector_from_surface))->norm();
      };
      const double a = distance(one), b = distance(other);
      if (std::abs(a - b) < 3e-3 * std::min(a, b)) continue;  // they lie together there
      (value == 255 ? whites : greys)++;
      EXPECT_EQ(value, a < b ? 255 : 99) << x << ", " << y;
    }
  EXPECT_GT(whites, 500);
  EXPECT_GT(greys, 500);
}

// The few pixels at a globe's limb hold very much of the content. Those beside them must not be blurred for
// it.
TEST(RenderRoom, IsSharpUpToTheLimbOfAGlobe) {
  BallAndWall room;
  room.ball.left = -2.1;
  room.ball.right = 2.1;
  ImageU8 stripes(600, 400, 1, 0);
  for (int y = 0; y < 400; ++y)
    for (int x = 0; x < 600; ++x) stripes.at(x, y) = (x / 40) % 2 ? 255 : 0;
  Scene scene;
  scene.items = {
      {PlacedMesh{mesh_of(Surface{"ball", room.ball, {}, ""}), room.projector_from_ball}, stripes}};
  const ImageU8 frame = render::render(scene, room.projector);
  int grey_run = 0, longest = 0, whites = 0;
  for (int y = 250; y < 490; ++y)
    for (int x = 400; x < 640; ++x) {  // a square inside the ball's outline
      const double light = light_of(frame.at(x, y));
      grey_run = light > 0.02 && light < 0.98 ? grey_run + 1 : 0;
      longest = std::max(longest, grey_run);
      whites += light > 0.98;
    }
  EXPECT_GT(whites, 10000);
  EXPECT_LE(longest, 4) << "pixels from black to white along a row";
}

/// Triangles without any order: small and large, slivers, across and behind the projector, in and out of its
/// picture, through each other.
Mesh scattered_triangles(std::mt19937_64& random) {
  std::uniform_real_distribution<double> any(0, 1), either(-1, 1);
  Mesh mesh;
  for (int i = 0; i < 90; ++i) {
    const double distance = 0.5 + 3 * any(random), size = std::pow(10.0, -2.5 + 2.3 * any(random));
    const Vec3 direction = Vec3(0.5 * either(random), 0.4 * either(random) - 0.2, i % 9 == 0 ? -0.3 : 1);
    Vec3 corner[3];
    for (Vec3& p : corner)
      p = distance * (direction + size * Vec3(either(random), either(random), either(random)));
    if (i % 5 == 1) corner[2] = corner[1] + 0.02 * (corner[2] - corner[1]);  // a sliver
    if (i % 10 == 3) corner[0] = -corner[0];                                 // from before to behind
    if (i == 77) {  // before all others; its upper edge, seen through a lens, bows out beyond its corners
      corner[0] = 0.3 * Vec3(-0.34, -0.3, 1);
      corner[1] = 0.3 * Vec3(0.5, -0.3, 1);
      corner[2] = 0.3 * Vec3(0.1, -0.2, 1);
    }
    const int first = int(mesh.vertices.size());
    for (const Vec3& p : corner) {
      mesh.vertices.push_back(p);
      mesh.uv.emplace_back(0.1 + 0.8 * any(random), 0.1 + 0.8 * any(random));
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

/// The triangle that a ray meets first, and the content coordinates there (Moeller and Trumbore, 1997).
struct Met {
  int triangle = -1;
  Vec2 uv = Vec2::Zero();
};
Met first_met(const Mesh& mesh, const Vec3& d) {
  Met met;
  double nearest = 1e9;
  for (std::size_t n = 0; n < mesh.triangles.size(); ++n) {
    const auto corner = [&](std::size_t k) { return std::size_t(mesh.triangles[n][k]); };
    const Vec3 p = mesh.vertices[corner(0)], by_b = mesh.vertices[corner(1)] - p,
               by_c = mesh.vertices[corner(2)] - p;
    const Vec3 across = d.cross(by_c), up = (-p).cross(by_b);
    const double inverse = 1 / by_b.dot(across), b = inverse * (-p).dot(across), c = inverse * d.dot(up);
    const double distance = inverse * by_c.dot(up);
    if (!(b >= 0 && c >= 0 && b + c <= 1 && distance > 0 && distance < nearest)) continue;
    nearest = distance;
    met = {int(n), (1 - b - c) * mesh.uv[corner(0)] + b * mesh.uv[corner(1)] + c * mesh.uv[corner(2)]};
  }
  return met;
}

TEST(RenderRoom, ShowsTheTrianglesThatRaysMeet) {
  constexpr int kTexels = 64;
  ImageU8 ramps(kTexels, kTexels, 3, 255);  // u in red, v in green
  for (int y = 0; y < kTexels; ++y)
    for (int x = 0; x < kTexels; ++x)
      ramps.at(x, y, 0) = std::uint8_t(4 * x), ramps.at(x, y, 1) = std::uint8_t(4 * y);
  // Not whole tiles; the last with a lens that bends lines by tens of pixels.
  const Projector projectors[] = {{Camera{{301, 187}, {350, 331, 120.3, 140.6, 2.1}, NoDistortion{}}},
                                  {Camera{{301, 187}, {350, 331, 120.3, 140.6, 2.1}, brown(-0.35)}}};
  for (const Projector& projector : projectors)
    for (const unsigned seed : {1u, 2u, 3u}) {
      std::mt19937_64 random(seed);
      const Mesh mesh = scattered_triangles(random);
      Scene scene;
      scene.items.push_back({PlacedMesh{std::make_shared<const Mesh>(mesh), Pose::identity()}, ramps});
      render::RenderOptions chosen = options(false, 1);
      chosen.filter = render::Filter::kBilinear;
      const ImageU8 frame = render::render(scene, projector, chosen);

      int compared = 0, lit = 0, wrong = 0;
      for (int y = 0; y < frame.height(); ++y)
        for (int x = y % 3; x < frame.width(); x += 3) {
          // Pixels that show one triangle, or nothing, all over.
          const auto met_at = [&](double dx, double dy) {
            return first_met(mesh, projector.emit(Vec2(x + dx, y + dy))->direction);
          };
          const Met met = met_at(0, 0);
          bool same = true;
          for (const double dy : {-0.6, -0.2, 0.2, 0.6})
            for (const double dx : {-0.6, -0.2, 0.2, 0.6})
              same = same && met_at(dx, dy).triangle == met.triangle;
          if (!same) continue;
          ++compared;
          lit += met.triangle >= 0;
          const Vec3 expected = met.triangle < 0 ? Vec3(0, 0, 0)
                                                 : Vec3(4 * (kTexels * met.uv.x() - 0.5),
                                                        4 * (kTexels * met.uv.y() - 0.5), 255);
          for (int k = 0; k < 3; ++k) wrong += std::abs(frame.at(x, y, k) - expected[k]) > 2;
        }
      EXPECT_GT(compared, 13000) << seed;
      EXPECT_GT(lit, 2600) << seed;
      EXPECT_EQ(wrong, 0) << "of " << compared << ", seed " << seed;

      // The same bits from plain code, and from a renderer that had it elsewhere before, and kept it; masked.
      ImageU8 mask(40, 1, 1);
      for (int x = 0; x < 40; ++x) mask.at(x, 0) = std::uint8_t(std::clamp(16 * (x - 12), 0, 255));
      scene.items[0].mask = mask;
      for (const render::Filter filter : {render::Filter::kBilinear, render::Filter::kArea}) {
        chosen.filter = filter;
        const ImageU8 wide = render::render(scene, projector, chosen);
        render::RenderOptions plain = chosen;
        plain.vector_bits = 0;
        plain.threads = 3;
        render::CpuRenderer renderer(plain);
        ImageU8 again(projector.size(), 3);
        Scene elsewhere = scene;
        std::get<PlacedMesh>(elsewhere.items[0].placement).projector_from_surface.translation.z() += 0.7;
        renderer.render(elsewhere, projector, again.view());
        for (int times = 0; times < 3; ++times) {
          renderer.render(scene, projector, again.view());
          EXPECT_TRUE(std::equal(wide.data(), wide.data() + wide.width() * wide.height() * 3, again.data()))
              << "seed " << seed << ", frame " << times;
        }
      }
    }
}

TEST(RenderRoom, IsTheSamePictureOnAnyNumberOfThreads) {
  const BallAndWall room;
  Scene scene;
  scene.items = {room.ball_item(), {room.wall.placement, room.green}};
  render::RenderOptions one, three;
  one.threads = 1;
  three.threads = 3;
  const ImageU8 a = render::render(scene, room.projector, one),
                b = render::render(scene, room.projector, three);
  EXPECT_TRUE(std::equal(a.data(), a.data() + 1024 * 768 * 3, b.data()));
}

}  // namespace
}  // namespace procam
