/// Content with depth for one viewer: where its light lands, through the true lens, as the eye sees it.
#include "procam/render/viewer.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "render/curved.hpp"

namespace procam {
namespace {

/// A surface in the room, met by rays; content coordinates do not matter.
SceneItem real(Placement placement) {
  static const ImageU8 grey(1, 1, 1, 128);
  return {std::move(placement), grey};
}

/// Two walls that meet at an edge before the projector, as in the corner of a room, and a post before them.
struct Corner {
  Projector projector = lopsided_projector(brown(-0.19));
  PlacedPlane left, right;
  CylinderSurface post;
  Pose projector_from_post;
  Vec3 eye{0.34, -0.21, 0.05};  ///< in the projector's frame: beside it

  Corner() {
    const Vec3 edge = 2.3 * projector.emit(Vec2(470, 380))->direction;
    const Mat3 tilt =
        (Eigen::AngleAxisd(0.07, Vec3::UnitX()) * Eigen::AngleAxisd(-0.05, Vec3::UnitZ())).toRotationMatrix();
    // Walls of 1.2 x 1.4 m whose right or left side is the edge.
    left.plane_from_content << 1.2, 0, -1.2, 0, 1.4, -0.7, 0, 0, 1;
    left.projector_from_surface =
        Pose(Mat3(tilt * Eigen::AngleAxisd(-0.8, Vec3::UnitY()).toRotationMatrix()), edge);
    right.plane_from_content << 1.2, 0, 0, 0, 1.4, -0.7, 0, 0, 1;
    right.projector_from_surface =
        Pose(Mat3(tilt * Eigen::AngleAxisd(0.6, Vec3::UnitY()).toRotationMatrix()), edge);
    post.radius = 0.06;
    post.left = -kPi;
    post.right = kPi;
    post.top = -0.5;
    post.bottom = 0.5;
    projector_from_post = Pose(tilt, 1.7 * projector.emit(Vec2(600, 390))->direction);
  }
  std::shared_ptr<const Mesh> post_mesh() const { return mesh_of(Surface{"post", post, {}, ""}); }
  Scene walls() const {
    Scene room;
    room.items = {real(left), real(right)};
    return room;
  }
  Scene with_post() const {
    Scene room = walls();
    room.items.push_back(real(PlacedMesh{post_mesh(), projector_from_post}));
    return room;
  }

  /// The nearest of the true walls (and post) that a ray in the projector's frame meets; nothing: nullopt.
  std::optional<Vec3> landing(const Ray& ray, bool post_stands) const {
    std::optional<Vec3> nearest;
    const auto take = [&](const Vec3& point) {
      const double s = (point - ray.origin).dot(ray.direction);
      if (s > 1e-6 && (!nearest || s < (*nearest - ray.origin).dot(ray.direction))) nearest = point;
    };
    for (const PlacedPlane* wall : {&left, &right}) {
      const auto point = intersect(ray, Plane::of_xy(wall->projector_from_surface));
      if (!point) continue;
      const Vec3 uv = wall->plane_from_content.inverse() *
                      Vec3((wall->projector_from_surface.inverse() * *point).head<2>().homogeneous());
      if (uv.x() >= 0 && uv.x() <= 1 && uv.y() >= 0 && uv.y() <= 1) take(*point);
    }
    if (post_stands) {
      const Ray local = projector_from_post.inverse() * ray;
      const Vec3 keep(1, 0, 1);
      const double a = local.direction.cwiseProduct(keep).squaredNorm(),
                   b = local.origin.cwiseProduct(keep).dot(local.direction),
                   c = local.origin.cwiseProduct(keep).squaredNorm() - post.radius * post.radius;
      for (const double sign : {-1.0, 1.0}) {
        if (!(b * b > a * c)) break;
        const Vec3 point = local.at((-b + sign * std::sqrt(b * b - a * c)) / a);
        if (std::abs(point.y()) <= 0.5) take(projector_from_post * point);
      }
    }
    return nearest;
  }
};

/// Sheets of discs that float before the walls, cut through them and stand behind.
std::vector<Sheet> virtual_sheets(const Corner& corner) {
  std::vector<Sheet> sheets;
  for (const double distance : {1.3, 2.3, 4.1}) {
    Sheet sheet =
        tilted_sheet(corner.projector, 0.4 * distance, 0.3 * distance, distance, 25, Vec2(500, 390));
    // Each at another place, so that none hides another's discs.
    sheet.placement.projector_from_surface.translation +=
        Vec3(0.11 * (distance - 2.3), 0.06 * distance, 0.02 * distance);
    sheets.push_back(sheet);
  }
  return sheets;
}

struct Drawn {
  render::ViewerEye eye;
  render::ViewerScene scene;
  ImageU8 frame;
};

Drawn draw(const Scene& content, const Scene& room, const Projector& projector, const Vec3& eye,
           const render::ViewerEyeOptions& eye_options = {}) {
  Drawn drawn{*render::viewer_eye(eye, room, projector, eye_options), {}, {}};
  const render::Viewpoint& from = drawn.eye.viewpoint;
  drawn.scene = render::viewer_scene(room, projector, from);
  render::render(render::seen_from(from.camera_from_projector, content), Projector{from.camera},
                 drawn.scene.picture);
  drawn.scene.picture_changed();
  drawn.frame = render::render(drawn.scene.scene, projector);
  return drawn;
}

// For 0.2 mm on the wall, with and without a lens, on planes that meet at an edge.
TEST(Viewer, PutsPointsOfTheRoomBehindTheWallWhereTheEyeSeesThem) {
  const Corner corner;
  const Discs discs;
  double worst_mm = 0, worst_px = 0;
  int looked_at = 0;
  for (const Sheet& sheet : virtual_sheets(corner)) {
    Scene content;
    content.items.push_back({sheet.placement, discs.picture});
    const Drawn drawn = draw(content, corner.walls(), corner.projector, corner.eye);
    EXPECT_GT(drawn.eye.finest_share, 0.99);
    EXPECT_TRUE(drawn.eye.diagnostics.items.empty());
    for (const Vec2& uv : discs.uv) {
      const Vec3 there = sheet.in_projector(uv.x(), uv.y());
      const auto expected = corner.landing({corner.eye, (there - corner.eye).normalized()}, false);
      if (!expected) continue;
      const auto near = corner.projector.project(*expected);
      if (!near || !PixelMargin{30}.holds(corner.projector.size(), *near)) continue;
      // A disc that lies across the corner is bent there, and its middle no longer its centre's place.
      if (std::abs((corner.left.projector_from_surface.inverse() * *expected).x()) < 0.015) continue;
      const auto middle = middle_of_light(drawn.frame, *near, 22);
      const auto landed = corner.landing(*corner.projector.emit(middle), false);
      ASSERT_TRUE(landed);
      ++looked_at;
      worst_mm = std::max(worst_mm, 1e3 * (*landed - *expected).norm());
      const render::Viewpoint& from = drawn.eye.viewpoint;
      worst_px = std::max(worst_px, (*from.camera.project(from.camera_from_projector * *landed) -
                                     *from.camera.project(from.camera_from_projector * there))
                                        .norm());
    }
  }
  EXPECT_GE(looked_at, 7);
  EXPECT_LT(worst_mm, 0.05) << "of a promised 0.2";
  EXPECT_LT(worst_px, 0.04) << "of the eye's picture";
}

TEST(Viewer, LandsOnCurvedSurfacesToATenthOfAMillimetre) {
  const Projector projector = lopsided_projector(brown(-0.19));
  const Discs discs;
  const Vec3 eye(-0.23, 0.17, 0.11);
  for (const Shaped& shape : shaped()) {
    Scene room;
    room.items = {
        real(PlacedMesh{mesh_of(Surface{shape.name, shape.geometry, {}, ""}), shape.projector_from_surface})};
    const Sheet sheet = tilted_sheet(projector, 0.45, 0.33, 2.9, 20, Vec2(500, 380));
    Scene content;
    content.items.push_back({sheet.placement, discs.picture});
    const Drawn drawn = draw(content, room, projector, eye);
    const bool ball = std::holds_alternative<SphereSurface>(shape.geometry);
    const auto curve = [&](const auto& of) { return std::make_pair(of.radius, of.seen_from); };
    const auto [radius, side] = ball ? curve(std::get<SphereSurface>(shape.geometry))
                                     : curve(std::get<CylinderSurface>(shape.geometry));
    const auto meet = [&, r = radius, far = side == SeenFrom::kInside](const Ray& ray) {
      return Vec3(shape.projector_from_surface *
                  on_quadric(shape.projector_from_surface.inverse() * ray, r, ball, far));
    };
    double worst = 0;
    int looked_at = 0;
    for (const Vec2& uv : discs.uv) {
      const Vec3 there = sheet.in_projector(uv.x(), uv.y());
      const Vec3 expected = meet({eye, (there - eye).normalized()});
      const auto near = projector.project(expected);
      if (!expected.allFinite() || !near || !PixelMargin{30}.holds(projector.size(), *near)) continue;
      if (drawn.frame.at(int(near->x() + 0.5), int(near->y() + 0.5), 0) == 0) continue;  // beside the shape
      ++looked_at;
      worst = std::max(
          worst, 1e3 * (meet(*projector.emit(middle_of_light(drawn.frame, *near, 22))) - expected).norm());
    }
    EXPECT_GE(looked_at, 3) << shape.name;
    EXPECT_LT(worst, 0.1) << shape.name << ": mm";
  }
}

/// Everything the eye may see is white.
Scene white_world(const Corner& corner) {
  static const ImageU8 white(1, 1, 1, 255);
  PlacedPlane far;
  far.plane_from_content << 90, 0, -45, 0, 90, -45, 0, 0, 1;
  far.projector_from_surface = Pose(Mat3::Identity(), Vec3(corner.eye + Vec3(0, 0, 9)));
  Scene content;
  content.items.push_back({far, white});
  return content;
}

/// Pixels lit though the eye does not see them, or dark though it does; those within a pixel of where that
/// changes are skipped.
int wrongly_lit(const Corner& corner, const ImageU8& frame, int& hidden) {
  const ImageSize size = frame.size();
  Image<std::uint8_t> seen(size.width, size.height, 1, 2);
  hidden = 0;
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const auto point = corner.landing(*corner.projector.emit(Vec2(x, y)), true);
      if (!point) continue;
      const auto first = corner.landing({corner.eye, (*point - corner.eye).normalized()}, true);
      seen.at(x, y) = first && (*first - *point).norm() < 2e-3;
      hidden += seen.at(x, y) == 0;
    }
  int wrong = 0;
  for (int y = 2; y < size.height - 2; ++y)
    for (int x = 2; x < size.width - 2; ++x) {
      bool border = false;
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) border = border || seen.at(x + dx, y + dy) != seen.at(x, y);
      if (!border) wrong += (seen.at(x, y) == 1 ? 255 : 0) != frame.at(x, y, 0);
    }
  return wrong;
}

TEST(Viewer, LeavesDarkWhatTheEyeDoesNotSee) {
  const Corner corner;
  int hidden = 0;
  const Drawn drawn = draw(white_world(corner), corner.with_post(), corner.projector, corner.eye);
  EXPECT_EQ(wrongly_lit(corner, drawn.frame, hidden), 0);
  EXPECT_GT(hidden, 10000) << "the post hides this much of the light from the eye";
  EXPECT_GT(drawn.scene.seen_share, 0.5);
  EXPECT_LT(drawn.scene.seen_share, 0.99);
}

// A scan of a room is one mesh: a part of it hides another.
TEST(Viewer, LeavesDarkWhatTheSameMeshHides) {
  const Corner corner;
  Mesh all;
  const auto add = [&](const Mesh& mesh, const Pose& pose) {
    const int first = int(all.vertices.size());
    for (const Vec3& vertex : mesh.vertices) all.vertices.push_back(pose * vertex);
    all.uv.resize(all.vertices.size(), Vec2::Zero());
    for (std::array<int, 3> triangle : mesh.triangles) {
      for (int& corner_of : triangle) corner_of += first;
      all.triangles.push_back(triangle);
    }
  };
  add(*corner.post_mesh(), corner.projector_from_post);
  for (const PlacedPlane* wall : {&corner.left, &corner.right}) {
    Mesh quad;
    for (const Vec2& uv : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)}) {
      const Vec2 p = (wall->plane_from_content * uv.homogeneous()).hnormalized();
      quad.vertices.emplace_back(p.x(), p.y(), 0);
    }
    quad.triangles = {{0, 1, 2}, {0, 2, 3}};
    add(quad, wall->projector_from_surface);
  }
  Scene room;
  room.items = {real(PlacedMesh{std::make_shared<const Mesh>(all), Pose::identity()})};
  int hidden = 0;
  const Drawn drawn = draw(white_world(corner), room, corner.projector, corner.eye);
  EXPECT_EQ(wrongly_lit(corner, drawn.frame, hidden), 0);
  EXPECT_GT(hidden, 10000);
}

// The post's holes let light pass, and the eye.
TEST(Viewer, LooksThroughHoles) {
  const Corner corner;
  Scene room = corner.with_post();
  const ImageU8 nothing(8, 6, 1, 0);
  room.items.back().mask = nothing;
  const Scene content = white_world(corner);
  const Drawn holed = draw(content, room, corner.projector, corner.eye),
              without = draw(content, corner.walls(), corner.projector, corner.eye);
  ASSERT_EQ(holed.frame.size(), without.frame.size());
  int different = 0;
  for (int i = 0; i < 1024 * 768 * 3; ++i) different += holed.frame.data()[i] != without.frame.data()[i];
  EXPECT_EQ(different, 0);
}

// Seen from the eye, the lit walls look as the virtual scene does.
TEST(Viewer, ShowsTheEyeTheVirtualScene) {
  const Corner corner;
  ImageU8 picture(320, 240, 3);
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) {
      picture.at(x, y, 0) = std::uint8_t(128 + 100 * std::sin(x / 9.0 + y / 23.0));
      picture.at(x, y, 1) = std::uint8_t(128 + 100 * std::cos(y / 11.0));
      picture.at(x, y, 2) = std::uint8_t((x * y / 64) % 128 + 64);
    }
  Scene content;
  for (const Sheet& sheet : virtual_sheets(corner)) content.items.push_back({sheet.placement, picture});
  SphereSurface globe;
  globe.radius = 0.3;
  globe.left = -kPi;
  globe.right = kPi;
  globe.top = kPi / 2;
  globe.bottom = -kPi / 2;
  content.items.push_back(
      {PlacedMesh{mesh_of(Surface{"globe", globe, {}, ""}),
                  Pose(Mat3::Identity(), 3.1 * corner.projector.emit(Vec2(640, 420))->direction)},
       picture});
  const Drawn drawn = draw(content, corner.with_post(), corner.projector, corner.eye);
  const render::Viewpoint& from = drawn.eye.viewpoint;
  const Pose projector_from_eye = from.camera_from_projector.inverse();
  double sum = 0, largest = 0;
  int count = 0, lit = 0;
  for (int y = 3; y < from.camera.size.height - 3; y += 3)
    for (int x = 3; x < from.camera.size.width - 3; x += 3) {
      const Vec3 direction = projector_from_eye.rotate(*from.camera.unproject(Vec2(x, y)));
      const auto point = corner.landing({corner.eye, direction.normalized()}, true);
      const auto pixel = point ? corner.projector.project(*point) : std::nullopt;
      if (!pixel || !PixelMargin{3}.holds(corner.projector.size(), *pixel)) continue;
      const auto first = corner.landing(*corner.projector.emit(*pixel), true);
      if (!first || (*first - *point).norm() > 2e-3) continue;  // in the post's shadow
      const int px = int(std::lround(pixel->x())), py = int(std::lround(pixel->y()));
      // Bilinear in what the projector shows, of places away from edges of the picture.
      const int left = int(std::floor(pixel->x())), top = int(std::floor(pixel->y()));
      const double s = pixel->x() - left, t = pixel->y() - top;
      bool rough = false;
      for (int dy = -3; dy <= 3; ++dy)
        for (int dx = -3; dx <= 3; ++dx)
          for (int c = 0; c < 3; ++c)
            rough = rough || std::abs(drawn.frame.at(px + dx, py + dy, c) - drawn.frame.at(px, py, c)) > 60;
      if (rough) continue;
      for (int c = 0; c < 3; ++c) {
        const double shown =
            (1 - t) * ((1 - s) * drawn.frame.at(left, top, c) + s * drawn.frame.at(left + 1, top, c)) +
            t * ((1 - s) * drawn.frame.at(left, top + 1, c) + s * drawn.frame.at(left + 1, top + 1, c));
        const double off = std::abs(shown - drawn.scene.picture.at(x, y, c));
        sum += off;
        largest = std::max(largest, off);
        ++count;
        lit += shown > 20;
      }
    }
  EXPECT_GT(lit, 5000);
  EXPECT_LT(sum / count, 1.0) << "of 255";
  EXPECT_LT(largest, 40);
}

TEST(Viewer, SaysWhereItsPictureEnds) {
  const Corner corner;
  const Scene room = corner.walls();
  // Behind the walls' planes everything is still in sight (a translucent screen); at the foot of a wall not
  // all.
  const Vec3 close = corner.left.projector_from_surface * Vec3(-0.5, 0.1, -0.02);
  const auto near_wall = render::viewer_eye(close, room, corner.projector);
  ASSERT_TRUE(near_wall);
  EXPECT_NE(near_wall->diagnostics.find("viewer_field_cut"), nullptr);
  const Camera& camera = near_wall->viewpoint.camera;
  EXPECT_LE(double(camera.size.width) * camera.size.height, 1.01 * (16 << 20) + 20000);
  EXPECT_FALSE(render::viewer_eye(corner.eye, {}, corner.projector)) << "there is no room";
  render::ViewerEyeOptions few;
  few.max_pixels = 100000;
  const auto coarse = render::viewer_eye(corner.eye, room, corner.projector, few);
  EXPECT_NE(coarse->diagnostics.find("viewer_picture_coarse"), nullptr);
  EXPECT_LT(coarse->finest_share, 0.5);
  EXPECT_THROW(render::viewer_eye(Vec3(0, std::nan(""), 0), room, corner.projector), std::invalid_argument);
  // Light beside and behind an eye in the middle of things is dark, not wrong, and nothing breaks.
  const Drawn drawn = draw(white_world(corner), room, corner.projector, close);
  EXPECT_LT(drawn.scene.seen_share, 0.99);
}

TEST(Viewpoint, IsNowhereForPixelSurfacesAlone) {
  const ImageU8 content(4, 4, 1, 9);
  Scene scene;
  scene.items.push_back({PlacedPixels{}, content});
  EXPECT_FALSE(render::facing_viewpoint(scene));
}

TEST(Viewpoint, SeesAllOfASurfaceThatIsNotFlat) {
  for (const Shaped& shape : shaped()) {
    Scene scene;
    const PlacedMesh placed{mesh_of(Surface{shape.name, shape.geometry, {}, ""}),
                            shape.projector_from_surface};
    scene.items.push_back(real(placed));
    const auto viewpoint = render::facing_viewpoint(scene);
    ASSERT_TRUE(viewpoint) << shape.name;
    for (const Vec3& vertex : placed.mesh->vertices) {
      const auto pixel = viewpoint->camera.project(viewpoint->camera_from_projector *
                                                   (placed.projector_from_surface * vertex));
      ASSERT_TRUE(pixel) << shape.name;
      EXPECT_TRUE((PixelMargin{8}.holds(viewpoint->camera.size, *pixel))) << shape.name;
    }
  }
}

}  // namespace
}  // namespace procam
