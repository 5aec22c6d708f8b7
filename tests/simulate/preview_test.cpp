/// What a viewer sees of a projection, against geometry and closed forms.
#include "procam/simulate/preview.hpp"

#include <gtest/gtest.h>

#include "procam/render/viewpoint.hpp"
#include "render/curved.hpp"
#include "room_hit.hpp"

namespace procam::simulate {
namespace {

/// A projection and somebody who looks at it.
struct Seen {
  Scene scene;
  Projector projector = lopsided_projector(brown(-0.2));
  Camera eye;
  Pose eye_from_projector;

  /// The one who faces it, moved and turned by `sideways`.
  void stand_before(const Pose& sideways = {}) {
    const auto viewpoint = render::facing_viewpoint(scene, {720, 480});
    ASSERT_TRUE(viewpoint);
    eye = viewpoint->camera;
    eye_from_projector = sideways * viewpoint->camera_from_projector;
  }
  ImageU8 preview(const ImageU8& frame, const PreviewOptions& options = {}) const {
    RoomLight light{projector, Pose(), {frame}};
    light.gamma = kSrgb;
    return simulate::preview(room_of(scene), {light}, eye, eye_from_projector.inverse(), options);
  }
  ImageU8 preview() const { return preview(render::render(scene, projector)); }
  ImageU8 full(std::uint8_t value) const { return preview(ImageU8(projector.size(), 3, value)); }
  Vec2 pixel_of(const Vec3& in_projector) const { return *eye.project(eye_from_projector * in_projector); }
};

const Pose kAside(Mat3(Eigen::AngleAxisd(0.3, Vec3(0.2, 1, 0.1).normalized())), Vec3(-0.5, 0.06, 0.1));

double light_at(const ImageU8& view, const Vec2& pixel, int channel = 1) {
  return light_of(view.at(int(std::lround(pixel.x())), int(std::lround(pixel.y())), channel));
}

/// Worst distance of the discs' light in the view from where geometry puts them, pixels.
template <typename PointAt>
double worst_disc(const Seen& seen, const Discs& discs, const PointAt& in_projector) {
  const ImageU8 view = seen.preview();
  ImageU8 green(view.size());
  for (int y = 0; y < view.height(); ++y)
    for (int x = 0; x < view.width(); ++x)
      green.at(x, y) = view.at(x, y, 1) > 100 ? view.at(x, y, 1) : std::uint8_t(0);  // without the room's own
  double worst = 0;
  for (const Vec2& uv : discs.uv) {
    const Vec2 expected = seen.pixel_of(in_projector(uv));
    worst = std::max(worst, (middle_of_light(green, expected, 12) - expected).norm());
  }
  return worst;
}

// A disc is some 10 px wide, of values up to 255, and of projector pixels as large as the view's: its middle
// is right to some hundredths.
constexpr double kDiscPx = 0.15;

TEST(Preview, ShowsAPlanesContentWhereItBelongs) {
  const Discs discs;
  Seen seen;
  const Sheet sheet = tilted_sheet(seen.projector, 0.4, 0.3, 1.6, 50);
  seen.scene.items.push_back({sheet.placement, discs.picture});
  for (const Pose& sideways : {Pose(), kAside}) {
    seen.stand_before(sideways);
    EXPECT_LT(worst_disc(seen, discs, [&](const Vec2& uv) { return sheet.in_projector(uv.x(), uv.y()); }),
              kDiscPx);
  }
}

TEST(Preview, ShowsCurvedContentWhereItBelongs) {
  const Discs discs;
  for (const Shaped& shape : shaped()) {
    Seen seen;
    const PlacedMesh placed{mesh_of(Surface{shape.name, shape.geometry, {}, ""}),
                            shape.projector_from_surface};
    seen.scene.items.push_back({placed, discs.picture});
    seen.stand_before(kAside);
    const auto in_projector = [&](const Vec2& uv) {
      return std::visit(
          [&](const auto& s) -> Vec3 {
            if constexpr (std::is_same_v<std::decay_t<decltype(s)>, CylinderSurface> ||
                          std::is_same_v<std::decay_t<decltype(s)>, SphereSurface>)
              return shape.projector_from_surface * s.point(uv);
            return Vec3::Zero();
          },
          shape.geometry);
    };
    EXPECT_LT(worst_disc(seen, discs, in_projector), kDiscPx) << shape.name;
  }
}

/// A folded sheet of few large triangles, uv along its arc: x, z at u = 0, 0.4, 1.
std::shared_ptr<const Mesh> folded_sheet() {
  auto mesh = std::make_shared<Mesh>();
  for (const double v : {0.0, 1.0})
    for (const auto& [u, x, z] : {std::tuple{0.0, -0.2, 0.0}, {0.4, 0.0, 0.11}, {1.0, 0.3, 0.02}}) {
      mesh->vertices.emplace_back(x, 0.35 * v - 0.2, z);
      mesh->uv.emplace_back(u, v);
    }
  mesh->triangles = {{0, 1, 3}, {1, 4, 3}, {1, 2, 4}, {2, 5, 4}};
  return mesh;
}

TEST(Preview, ShowsAMeshesContentWhereItBelongs) {
  const Discs discs;
  Seen seen;
  const PlacedMesh placed{folded_sheet(), Pose(Mat3(Eigen::AngleAxisd(0.2, Vec3(0.3, 1, 0.2).normalized())),
                                               1.7 * seen.projector.emit(Vec2(500, 380))->direction)};
  seen.scene.items.push_back({placed, discs.picture});
  const Body body{"sheet", TriangleMesh(placed.mesh), placed.projector_from_surface};
  seen.stand_before(kAside);
  EXPECT_LT(worst_disc(seen, discs, [&](const Vec2& uv) { return point_at(body, uv); }), kDiscPx);
}

// To the one who faces it, a square of the content is one.
TEST(Preview, ASquareIsSquareFromBeforeIt) {
  ImageU8 content(400, 300, 1);
  for (int y = 60; y < 240; ++y)
    for (int x = 110; x < 290; ++x) content.at(x, y) = 255;
  Seen seen;
  const Sheet sheet = tilted_sheet(seen.projector, 0.4, 0.3, 1.6, 60);
  seen.scene.items.push_back({sheet.placement, content});
  seen.stand_before();
  const ImageU8 view = seen.preview();
  // How long the light is along a row or column: the sum of its shares.
  const auto length = [&](const Vec2& uv, int axis) {
    const Vec2 p = seen.pixel_of(sheet.in_projector(uv.x(), uv.y()));
    const double white = light_at(view, p),
                 black = light_at(view, seen.pixel_of(sheet.in_projector(0.1, 0.5)));
    double sum = 0;
    for (int i = -170; i <= 170; ++i)
      sum += (light_at(view, p + i * Vec2::Unit(axis)) - black) / (white - black);
    return sum;
  };
  // Light falls off across the square: near its middle that evens out.
  const double across = length({0.5, 0.5}, 0), down = length({0.5, 0.5}, 1);
  EXPECT_GT(across, 150);
  EXPECT_NEAR(across / down, 1, 0.01);
  const Vec2 right =
      seen.pixel_of(sheet.in_projector(0.725, 0.5)) - seen.pixel_of(sheet.in_projector(0.275, 0.5));
  EXPECT_NEAR(right.norm() / across, 1, 0.02);
  EXPECT_NEAR(right.y() / right.x(), 0, 1e-6) << "upright";
}

// A white sheet at 60 degrees: its light falls with cos / d^2.
TEST(Preview, FallsOffWithDistanceAndAngle) {
  Seen seen;
  const Sheet sheet = tilted_sheet(seen.projector, 1.2, 0.5, 1.6, 60);
  const ImageU8 one(1, 1, 3, 255);
  seen.scene.items.push_back({sheet.placement, one});
  seen.stand_before();
  const ImageU8 white = seen.full(255), black = seen.full(0);
  const Vec3 normal = sheet.placement.projector_from_surface.rotate(Vec3::UnitZ());
  double least = 1e9, most = 0, min_light = 1e9, max_light = 0;
  int compared = 0;
  for (const double u : {0.3, 0.38, 0.46, 0.54, 0.62})
    for (const double v : {0.2, 0.5, 0.7}) {
      const Vec3 point = sheet.in_projector(u, v);
      if (!seen.projector.size().contains(*seen.projector.project(point))) continue;
      const Vec2 p = seen.pixel_of(point);
      if (light_at(white, p) == 1) continue;  // brighter than the picture is exposed for
      const double light = light_at(white, p) - light_at(black, p);
      const double irradiance = std::abs(point.dot(normal)) / std::pow(point.norm(), 3);
      least = std::min(least, light / irradiance);
      most = std::max(most, light / irradiance);
      min_light = std::min(min_light, light);
      max_light = std::max(max_light, light);
      ++compared;
    }
  EXPECT_GE(compared, 8);
  EXPECT_LT(most / least, 1.02) << "8 bits: 0.9 % a step of the value";
  EXPECT_GT(max_light / min_light, 1.4) << "and there is something to follow";
}

// A tube's light falls with the cosine towards its rim: smoothly, as on the tube, not facet by facet.
TEST(Preview, LightFallsSmoothlyRoundATube) {
  const Shaped shape = shaped()[0];
  const auto& column = std::get<CylinderSurface>(shape.geometry);
  Seen seen;
  const ImageU8 one(1, 1, 3, 255);
  seen.scene.items.push_back(
      {PlacedMesh{mesh_of(Surface{"column", column, {}, ""}), shape.projector_from_surface}, one});
  seen.stand_before();
  const ImageU8 white = seen.full(255), black = seen.full(0);
  double least = 1e9, most = 0;
  int compared = 0;
  for (double u = 0.03; u < 0.98; u += 0.019) {
    const Vec3 point = shape.projector_from_surface * column.point({u, 0.5});
    const Vec2 p = seen.pixel_of(point);
    if (light_at(white, p) == 1) continue;
    const double angle = column.left + u * (column.right - column.left);
    const Vec3 normal = shape.projector_from_surface.rotate(Vec3(std::sin(angle), 0, -std::cos(angle)));
    const double irradiance = -point.dot(normal) / std::pow(point.norm(), 3);
    // The place to half a pixel: a tenth of a degree of the tube.
    const double per_irradiance = (light_at(white, p) - light_at(black, p)) / irradiance;
    least = std::min(least, per_irradiance);
    most = std::max(most, per_irradiance);
    ++compared;
  }
  EXPECT_GE(compared, 30);
  EXPECT_LT(most / least, 1.03);
}

/// A wall, and before it a column whose shadow falls on it.
struct WallAndColumn : Seen {
  CylinderSurface column;
  Vec3 axis = projector.emit(Vec2(512, 380))->direction;
  Pose projector_from_column{Mat3::Identity(), Vec3(1.5 * axis)};
  PlacedPlane wall;
  ImageU8 white{8, 6, 1, 255}, halves{80, 60, 3, 0};

  WallAndColumn() {
    column.radius = 0.08;
    column.left = -2;
    column.right = 2;
    column.top = -0.25;
    column.bottom = 0.25;
    wall.plane_from_content << 1.2, 0, -0.6, 0, 0.9, -0.45, 0, 0, 1;
    wall.projector_from_surface = Pose(Mat3::Identity(), 1.9 * axis);
    for (int y = 0; y < 60; ++y)
      for (int x = 0; x < 80; ++x) halves.at(x, y, x < 40 ? 0 : 2) = 255;  // red and blue
    scene.items = {{wall, white},
                   {PlacedMesh{mesh_of(Surface{"column", column, {}, ""}), projector_from_column}, halves}};
  }
  /// On the wall, along the light that passes the column's middle at x.
  Vec3 behind(double x) const {
    return *intersect(Ray{Vec3::Zero(), 1.5 * axis + Vec3(x, 0, 0)},
                      Plane::of_xy(wall.projector_from_surface));
  }
};

TEST(Preview, WhatTheProjectorDoesNotSeeIsDark) {
  WallAndColumn seen;
  seen.stand_before(kAside);
  const ImageU8 view = seen.preview();
  const auto at = [&](const Vec3& point, int channel) {
    return light_at(view, seen.pixel_of(point), channel);
  };
  const Vec3 red = seen.projector_from_column * seen.column.point({0.47, 0.5}),
             blue = seen.projector_from_column * seen.column.point({0.53, 0.5});
  EXPECT_GT(at(red, 0), 0.5);
  EXPECT_LT(at(red, 2), 0.1);
  EXPECT_GT(at(blue, 2), 0.5);
  EXPECT_LT(at(blue, 0), 0.1);
  // The shadow's border: where light grazes the tube, at its sides as the projector sees them.
  EXPECT_GT(at(seen.behind(-0.2), 1), 0.4);
  EXPECT_GT(at(seen.behind(0.1), 1), 0.4);
  EXPECT_NEAR(at(seen.behind(0.07), 1), 0.04 / 1.04, 0.01)
      << "in the column's shadow: the room's light alone";
  const ImageU8 white = seen.full(255);
  double border = 0;
  for (double x = 0.06; x < 0.1; x += 1e-5)
    if (light_at(white, seen.pixel_of(seen.behind(x)), 1) < 0.3) border = x;
  const Vec3 to_axis = 1.5 * seen.axis;  // in the plane across the column
  const double distance = std::hypot(to_axis.x(), to_axis.z());
  const double half = std::asin(0.08 / distance), towards = std::atan2(to_axis.x(), to_axis.z());
  const double expected = to_axis.z() * std::tan(towards + half) - to_axis.x();
  const double pixel =
      1 / (seen.pixel_of(seen.behind(0.0805)) - seen.pixel_of(seen.behind(0.0795))).norm() * 1e-3;
  EXPECT_NEAR((border - expected) / pixel, 0, 1) << "px";
}

// A hole of the mask lets light and eye pass. To an eye beside the projector another part of what stands
// behind shows in the hole than the one that the projector sees there.
TEST(Preview, LightAndEyePassAHole) {
  Seen seen;
  const Sheet front = tilted_sheet(seen.projector, 0.3, 0.24, 1.5, 12),
              back = tilted_sheet(seen.projector, 0.8, 0.6, 2.0, 5);
  ImageU8 mask(64, 48, 1, 255);
  for (int y = 12; y < 36; ++y)
    for (int x = 16; x < 48; ++x) mask.at(x, y) = 0;
  const Vec3 eye(0.15, 0.01, 0), middle = front.in_projector(0.5, 0.5);
  seen.eye = seen.projector.inverse_camera;
  seen.eye_from_projector = Pose(Mat3::Identity(), -eye);
  const auto behind =
      [&](const Vec3& from) {  // the column of a content of 800 that shows in the hole's middle
        const Vec3 point =
            *intersect(Ray{from, middle - from}, Plane::of_xy(back.placement.projector_from_surface));
        const Vec3 on_plane = back.placement.projector_from_surface.inverse() * point;
        return 800 * (on_plane.x() + 0.4 * back.width) / back.width;
      };
  const double to_eye = behind(eye), to_projector = behind(Vec3::Zero());
  ASSERT_GT(std::abs(to_eye - to_projector), 40);
  ImageU8 halves(800, 600, 3, 0), red(1, 1, 3, 0);
  red.at(0, 0, 0) = 255;
  for (int y = 0; y < 600; ++y)
    for (int x = 0; x < 800; ++x)  // green where the eye looks, blue where the projector does
      halves.at(x, y, std::abs(x - to_eye) < std::abs(x - to_projector) ? 1 : 2) = 255;
  seen.scene.items = {{back.placement, halves}, {front.placement, red}};
  seen.scene.items[1].mask = mask;
  const ImageU8 view = seen.preview();
  const auto at = [&](double u, double v, int channel) {
    return light_at(view, seen.pixel_of(front.in_projector(u, v)), channel);
  };
  EXPECT_GT(at(0.5, 0.5, 1), 0.2);
  EXPECT_LT(at(0.5, 0.5, 2), 0.1);
  EXPECT_LT(at(0.5, 0.5, 0), 0.1);
  EXPECT_GT(at(0.23, 0.5, 0), 0.3) << "beside the hole";
  EXPECT_LT(at(0.23, 0.5, 1), 0.1);
}

// The grey round a plane's content neither hides nor shades another's content.
TEST(Preview, APlanesMarginHidesNothing) {
  Seen seen;
  const Sheet near = tilted_sheet(seen.projector, 0.2, 0.2, 1.4, 8, Vec2(420, 380)),
              far = tilted_sheet(seen.projector, 0.25, 0.2, 1.8, 8, Vec2(720, 380));
  const ImageU8 one(1, 1, 3, 255);
  seen.scene.items = {{far.placement, one}, {near.placement, one}};
  // Seen from the projector the near margin reaches over a part of the far content, and its light as well.
  const Vec3 margin = near.in_projector(1.15, 0.5);
  const auto in_far = far.landed(seen.projector, *seen.projector.project(margin));
  const Vec2 low = far.plane_point(0, 0), high = far.plane_point(1, 1);
  ASSERT_TRUE(in_far && in_far->x() > low.x() && in_far->x() < high.x() && in_far->y() > low.y() &&
              in_far->y() < high.y());
  seen.eye = seen.projector.inverse_camera;
  seen.eye_from_projector = Pose(Mat3::Identity(), Vec3(-0.02, 0.01, 0));
  const ImageU8 white = seen.preview();
  const Room room = room_of(seen.scene);
  const Vec3 point = far.placement.projector_from_surface * Vec3(in_far->x(), in_far->y(), 0);
  const auto hit = nearest_hit(room, {Vec3(0.02, -0.01, 0), point - Vec3(0.02, -0.01, 0)});
  ASSERT_TRUE(hit);
  EXPECT_EQ(room.bodies[std::size_t(hit->body)].name, "0") << "the far content";
  EXPECT_GT(light_at(white, seen.pixel_of(point)), 0.4);
}

// Half the light each, from two places: together what one gives alone.
TEST(Preview, LightsOfSeveralProjectorsAddUp) {
  Seen seen;
  const Sheet sheet = tilted_sheet(seen.projector, 0.4, 0.3, 1.8, 10);
  const ImageU8 one(1, 1, 3, 255);
  seen.scene.items.push_back({sheet.placement, one});
  seen.stand_before();
  const auto look = [&](const std::vector<RoomLight>& lights) {
    return preview(room_of(seen.scene), lights, seen.eye, seen.eye_from_projector.inverse());
  };
  const std::uint8_t half = 188;  // sRGB of one half
  const auto lamp = [&](std::uint8_t value) {
    RoomLight light{seen.projector, Pose(), {ImageU8(seen.projector.size(), 3, value)}};
    light.gamma = kSrgb;
    return light;
  };
  const Vec2 p = seen.pixel_of(sheet.in_projector(0.4, 0.6));
  const double alone = light_at(look({lamp(255)}), p), both = light_at(look({lamp(half), lamp(half)}), p);
  EXPECT_NEAR(both, alone, 0.01);
  EXPECT_NEAR(light_at(look({lamp(half)}), p), 0.5 * alone, 0.03);
  RoomLight dim = lamp(0);
  dim.black = 0.25;
  const double dark = light_at(look({lamp(0)}), p);
  EXPECT_NEAR(light_at(look({dim}), p) - dark, 0.25 * (alone - dark), 0.01) << "a projector's black";
}

TEST(Preview, IsTheSameByAnyNumberOfThreads) {
  WallAndColumn seen;
  seen.stand_before(kAside);
  const ImageU8 frame = render::render(seen.scene, seen.projector);
  const ImageU8 one = seen.preview(frame, {0.04, 1}), three = seen.preview(frame, {0.04, 3});
  EXPECT_TRUE(
      std::equal(one.data(), one.data() + std::ptrdiff_t(one.width()) * one.height() * 3, three.data()));
}

TEST(Preview, ShowsTheRoomWithoutAnyLightOfAProjector) {
  Seen seen;
  const Sheet sheet = tilted_sheet(seen.projector, 0.4, 0.3, 1.8, 10);
  const ImageU8 one(1, 1, 3, 255);
  seen.scene.items.push_back({sheet.placement, one});
  seen.stand_before();
  const ImageU8 view = preview(room_of(seen.scene), {}, seen.eye, seen.eye_from_projector.inverse());
  EXPECT_GT(light_at(view, seen.pixel_of(sheet.in_projector(0.5, 0.5))), 0.02);
  EXPECT_THROW(preview({}, {}, seen.eye, Pose(), {-1, 0}), std::invalid_argument);
}

}  // namespace
}  // namespace procam::simulate
