/// Bodies of triangles, cutouts and backdrops.
#include <gtest/gtest.h>

#include "../support/lopsided.hpp"
#include "procam/core/surface/surface.hpp"
#include "procam/simulate/depth_view.hpp"
#include "room_hit.hpp"
#include "rooms.hpp"

namespace procam::simulate {
namespace {

using procam::test::lopsided_pose;
using procam::test::random_vec3;
using procam::test::uniform;
using test::hung;
using test::looking_at;

/// Triangles anywhere, many through each other.
std::shared_ptr<const Mesh> soup(int triangles, std::mt19937_64& random) {
  auto mesh = std::make_shared<Mesh>();
  for (int i = 0; i < triangles; ++i) {
    const Vec3 place = random_vec3(random, 1);
    for (int k = 0; k < 3; ++k) {
      mesh->vertices.push_back(place + random_vec3(random, i % 10 == 0 ? 0.9 : 0.1));
      mesh->uv.emplace_back(uniform(random, 0, 1), uniform(random, 0, 1));
    }
    mesh->triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

/// By Cramer's rule, triangle by triangle.
std::optional<double> nearest_by_hand(const Mesh& mesh, const Ray& ray) {
  std::optional<double> nearest;
  for (const auto& triangle : mesh.triangles) {
    const Vec3& a = mesh.vertices[std::size_t(triangle[0])];
    Mat3 m;
    m << mesh.vertices[std::size_t(triangle[1])] - a, mesh.vertices[std::size_t(triangle[2])] - a,
        -ray.direction;
    const Vec3 x = m.inverse() * (ray.origin - a);
    if (x.x() >= 0 && x.y() >= 0 && x.x() + x.y() <= 1 && x.z() > 0 && (!nearest || x.z() < *nearest))
      nearest = x.z();
  }
  return nearest;
}

TEST(MeshBody, RaysFindTheNearestTriangleOfAll) {
  std::mt19937_64 random(11);
  const std::shared_ptr<const Mesh> mesh = soup(700, random);
  Room room;
  room.bodies = {{"soup", TriangleMesh(mesh), lopsided_pose()}};
  int met = 0;
  for (int i = 0; i < 2000; ++i) {
    Ray ray{random_vec3(random, 2), random_vec3(random, 1)};
    if (i % 7 == 0) ray.direction[i % 3] = 0;  // along the boxes' sides
    const auto expected = nearest_by_hand(*mesh, ray);
    const auto hit = nearest_hit(room, lopsided_pose() * ray);
    ASSERT_EQ(bool(hit), bool(expected)) << i;
    if (!hit) continue;
    ++met;
    EXPECT_NEAR(hit->lengths, *expected, 1e-9 * *expected) << i;
    EXPECT_LT(hit->normal_in_room.dot(lopsided_pose().rotate(ray.direction)), 0);
  }
  EXPECT_GT(met, 500);
}

std::shared_ptr<const Mesh> ball_mesh(double radius) {
  SphereSurface ball;
  ball.radius = radius;
  ball.left = -kPi;
  ball.right = kPi;
  ball.top = kPi / 2;
  ball.bottom = -kPi / 2;
  return mesh_of(Surface{"ball", ball, {}, ""});
}

TEST(MeshBody, IsTight) {
  std::mt19937_64 random(5);
  const auto mesh = ball_mesh(0.3);
  Room room;
  room.bodies = {{"ball", TriangleMesh(mesh), lopsided_pose()}};
  const Vec3 eye = lopsided_pose() * Vec3(0.02, -0.01, 0.03);
  for (std::size_t i = 0; i < mesh->triangles.size(); ++i) {  // through corners and sides, from inside
    const auto corner = [&](std::size_t k) {
      return lopsided_pose() * mesh->vertices[std::size_t(mesh->triangles[i][k])];
    };
    for (const double t : {0.0, 0.31, 0.5, uniform(random, 0, 1)})
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 target = (1 - t) * corner(k) + t * corner((k + 1) % 3);
        const auto hit = nearest_hit(room, {eye, target - eye});
        ASSERT_TRUE(hit) << i;
        ASSERT_NEAR(hit->lengths, 1, 1e-8);
      }
    if (i > 3000) break;
  }
}

/// A room with a ball and a tube: as round bodies, or as their triangles to 0.1 mm.
Room round_room(bool as_triangles) {
  Room room;
  room.ambient = 0.02;
  room.bodies.push_back(hung("wall", Vec3(0.1, 2.9, 1.1), Vec3(-0.1, -1, 0.05), Vec2(4, 3), test::poster()));
  const Pose room_from_ball(so3_exp(Vec3(0.4, -0.3, 1.1)), Vec3(0.3, 2.0, 1.0)),
      room_from_tube(so3_exp(Vec3(0.1, 0.2, 0)), Vec3(-0.3, 2.2, 0.6));
  if (as_triangles) {
    CylinderSurface tube;  // about its y axis
    tube.radius = 0.17;
    tube.left = -kPi;
    tube.right = kPi;
    tube.top = 0;
    tube.bottom = 0.8;
    const Pose tube_from_surface(so3_exp(Vec3(M_PI_2, 0, 0)), Vec3::Zero());
    room.bodies.push_back({"ball", TriangleMesh(ball_mesh(0.24)), room_from_ball});
    room.bodies.push_back({"tube", TriangleMesh(mesh_of(Surface{"tube", tube, {}, ""})),
                           room_from_tube * tube_from_surface, 0.5});
  } else {
    room.bodies.push_back({"ball", Sphere{0.24}, room_from_ball});
    room.bodies.push_back({"tube", Cylinder{0.17, 0, 0.8}, room_from_tube, 0.5});
  }
  return room;
}

TEST(MeshBody, LooksAsTheShapeThatItStandsFor) {
  RoomViewOptions options;
  options.exposure = 900;
  const auto look = [&](bool as_triangles) {
    return room_view(round_room(as_triangles), test::room_camera(), test::room_from_camera(),
                     {test::room_light()}, options);
  };
  const RoomView round = look(false), mesh = look(true);
  int other_body = 0, off = 0, compared = 0;
  for (int y = 0; y < 512; ++y)
    for (int x = 0; x < 640; ++x) {
      if (round.truth.body.at(x, y) != mesh.truth.body.at(x, y)) {
        ++other_body;
        continue;
      }
      if (round.truth.body.at(x, y) < 1) continue;
      ++compared;
      // At the limb 0.1 mm are some millimetres along the ray.
      off += std::abs(round.truth.depth.at(x, y) - mesh.truth.depth.at(x, y)) > 0.003 ||
             std::abs(int(round.image().at(x, y)) - int(mesh.image().at(x, y))) > 2;
    }
  EXPECT_GT(compared, 15000);
  EXPECT_LT(other_body, 150) << "pixels, of outlines of 1500";
  EXPECT_LT(off, compared / 100);
}

TEST(MeshBody, SharpEdgesStaySharp) {
  // Two squares at a right angle, and two at 10 degrees.
  for (const double turn : {90.0, 10.0}) {
    auto mesh = std::make_shared<Mesh>();
    const double c = std::cos(turn * kDegree), s = std::sin(turn * kDegree);
    for (const double v : {0.0, 1.0})
      for (const auto& [u, x, z] : {std::tuple{0.0, -1.0, 0.0}, {0.5, 0.0, 0.0}, {1.0, c, s}}) {
        mesh->vertices.emplace_back(x, v, z);
        mesh->uv.emplace_back(u, v);
      }
    mesh->triangles = {{0, 1, 3}, {1, 4, 3}, {1, 2, 4}, {2, 5, 4}};
    Room room;
    room.bodies = {{"fold", TriangleMesh(mesh), Pose(Mat3::Identity(), Vec3(0, -0.5, 2)), 0.8}};
    RoomLight lamp;
    lamp.projector = {{{400, 400}, {200, 200, 199.5, 199.5, 0}, NoDistortion{}}};
    lamp.frames = {ImageU8(400, 400, 1, 255)};
    RoomViewOptions options;
    options.exposure = 1000;
    const Camera eye{{401, 101}, {300, 300, 200, 50, 0}, NoDistortion{}};
    const ImageU8 image = room_view(room, eye, Pose(), {lamp}, options).image();
    const int across_fold = std::abs(int(image.at(198, 50)) - int(image.at(202, 50)));
    if (turn > 45)
      EXPECT_GT(across_fold, 60);
    else
      EXPECT_LE(across_fold, 2);
  }
}

TEST(MeshBody, IsSeenByADepthSensor) {
  Room room;
  room.bodies = round_room(true).bodies;
  DepthSensor sensor;
  sensor.camera = {{320, 250}, {293, 288, 151, 131, 0.4}, BrownConrady{{-0.05, 0.01, 0.0004, -0.0006, 0}}};
  const Pose eye = test::room_from_camera();
  const DepthView view = depth_view(room, sensor, eye, 1);
  int on_mesh = 0;
  for (int y = 1; y < 250; y += 4)
    for (int x = 1; x < 320; x += 4) {
      const auto hit = nearest_hit(room, eye * Ray{Vec3::Zero(), *sensor.camera.unproject(Vec2(x, y))});
      ASSERT_EQ(view.body.at(x, y), hit ? hit->body : -1);
      if (!hit) continue;
      on_mesh += hit->body > 0;
      EXPECT_NEAR(view.true_metres.at(x, y), (eye.inverse() * hit->point_in_room).z(), 1e-6);
    }
  EXPECT_GT(on_mesh, 300);
}

TEST(MeshBody, FewRaysShowTheSameAsAll) {
  RoomViewOptions options;
  options.exposure = 900;
  options.samples_per_axis = 3;
  ImageU8 frame(512, 390, 1);
  for (int y = 0; y < 390; ++y)
    for (int x = 0; x < 512; ++x) frame.at(x, y) = (x / 16 + y / 16) % 2 ? 255 : 40;
  const auto look = [&](bool adaptive) {
    options.adaptive = adaptive;
    return room_view(round_room(true), test::room_camera(), test::room_from_camera(),
                     {test::room_light(frame)}, options);
  };
  const RoomView all = look(false), few = look(true);
  int off = 0, far_off = 0, lit = 0;
  for (int y = 0; y < 512; ++y)
    for (int x = 0; x < 640; ++x) {
      ASSERT_EQ(all.truth.body.at(x, y), few.truth.body.at(x, y));
      const int difference = std::abs(int(all.image().at(x, y)) - int(few.image().at(x, y)));
      off += difference > 1;
      far_off += difference > 8;
      lit += all.image().at(x, y) > 60;
    }
  EXPECT_GT(lit, 10000);
  EXPECT_LT(off, 200);
  EXPECT_LT(far_off, 10);
}

TEST(Cutout, LetsRaysThrough) {
  Cutout cutout{ImageU8(40, 20, 1, 255), Mat3::Identity()};
  for (int y = 5; y < 15; ++y)
    for (int x = 10; x < 20; ++x) cutout.mask.at(x, y) = 0;
  const Pose place = lopsided_pose();
  std::vector<Body> bodies = {{"sheet", Rectangle{Vec2(-0.3, -0.1), Vec2(0.5, 0.3)}, place},
                              {"ball", Sphere{0.3}, place},
                              {"mesh", TriangleMesh(ball_mesh(0.3)), place}};
  for (Body& body : bodies) {
    body.cutout = cutout;
    Room room;
    room.bodies = {body};
    const auto through = [&](const Vec2& uv) {
      Body whole = body;
      whole.cutout.reset();
      const Vec3 point = point_at(whole, uv),
                 eye = place * Vec3(0.9 * (place.inverse() * point) + Vec3(0, 0, 1e-3));
      const auto hit = nearest_hit(room, {eye, point - eye});
      return !hit || hit->lengths > 1.5;
    };
    EXPECT_TRUE(through({0.4, 0.6})) << body.name;
    EXPECT_FALSE(through({0.2, 0.6})) << body.name;
    EXPECT_FALSE(through({0.4, 0.2})) << body.name;
    // Half a texel beside the hole's rim, where the mask is one half.
    EXPECT_TRUE(through({0.2501, 0.5})) << body.name;
    EXPECT_FALSE(through({0.2499, 0.5})) << body.name;
  }
}

TEST(Cutout, CutsTheViewAsOneRayWould) {
  Room room;
  room.ambient = 1;
  room.bodies = {hung("wall", Vec3(0.1, 2.9, 1.1), Vec3(-0.1, -1, 0.05), Vec2(4, 3), 0.3),
                 hung("frame", Vec3(0, 2.0, 1.0), Vec3(0.1, -1, 0.05), Vec2(1, 0.8), 0.8)};
  room.bodies[1].cutout = Cutout{ImageU8(8, 8, 1, 255), Mat3::Identity()};
  for (int y = 3; y < 6; ++y)
    for (int x = 2; x < 7; ++x) room.bodies[1].cutout->mask.at(x, y) = 0;
  const Camera camera = test::room_camera();
  const RoomLight light = test::room_light();
  const Pose eye = test::room_from_camera(), lamp = light.room_from_projector(0);
  const RoomView view = room_view(room, camera, eye, {light});
  int seen[2] = {0, 0}, wrong = 0, lit[2] = {0, 0}, wrongly_lit = 0;
  for (int y = 0; y < 512; y += 2)
    for (int x = 0; x < 640; x += 2) {
      const auto hit = nearest_hit(room, eye * Ray{Vec3::Zero(), *camera.unproject(Vec2(x, y))});
      wrong += view.truth.body.at(x, y) != (hit ? hit->body : -1);
      if (!hit) continue;
      ++seen[hit->body];
      const Vec3 way = hit->point_in_room - lamp.translation;
      const auto pixel = light.projector.project(lamp.inverse() * hit->point_in_room);
      if (!pixel || !light.projector.size().contains(*pixel)) continue;
      const bool reached = nearest_hit(room, {lamp.translation, way})->lengths > 1 - 1e-6;
      ++lit[reached];
      wrongly_lit += reached != bool(view.truth.light[0].lit.at(x, y));
    }
  EXPECT_GT(seen[0], 1000);
  EXPECT_GT(seen[1], 1000);
  EXPECT_GT(lit[0], 300);
  EXPECT_GT(lit[1], 3000);
  EXPECT_LT(wrong, 5);  // rays within 1e-3 px of a rim
  EXPECT_LT(wrongly_lit, 5);
}

TEST(Backdrop, IsBehindAllElse) {
  Room room;
  Body backdrop = hung("backdrop", Vec3(0, 1, 0), Vec3(0.05, -1, 0), Vec2(2, 2), 0.6);
  backdrop.backdrop = true;
  room.bodies = {backdrop, hung("sheet", Vec3(0, 2, 0), Vec3(0, -1, 0.1), Vec2(0.8, 0.6), 0.6)};
  EXPECT_EQ(nearest_hit(room, {Vec3::Zero(), Vec3(0.05, 1, 0.05)})->body, 1);
  EXPECT_EQ(nearest_hit(room, {Vec3::Zero(), Vec3(0.4, 1, 0.05)})->body, 0);
  // In a view: the same, no shadow on the sheet, and no light on the backdrop where the sheet catches it.
  const Camera camera = test::room_camera();
  const Pose eye = looking_at(Vec3(-0.4, 0, 0.1), Vec3(0, 2, 0));
  RoomLight lamp = test::room_light();
  lamp.room_from_projector = looking_at(Vec3(0.3, 0, 0.1), Vec3(0, 2, 0));
  const RoomTruth truth = room_view(room, camera, eye, {lamp}).truth;
  int seen[2] = {0, 0}, lit[2] = {0, 0};
  for (int y = 0; y < 512; y += 3)
    for (int x = 0; x < 640; x += 3) {
      const auto hit = nearest_hit(room, eye * Ray{Vec3::Zero(), *camera.unproject(Vec2(x, y))});
      ASSERT_EQ(truth.body.at(x, y), hit ? hit->body : -1);
      if (!hit) continue;
      ++seen[hit->body];
      const Pose room_from_lamp = lamp.room_from_projector(0);
      const auto pixel = lamp.projector.project(room_from_lamp.inverse() * hit->point_in_room);
      const bool in_picture = pixel && lamp.projector.size().contains(*pixel);
      const auto met =
          nearest_hit(room, {room_from_lamp.translation, hit->point_in_room - room_from_lamp.translation});
      ASSERT_EQ(bool(truth.light[0].lit.at(x, y)), in_picture && met->body == hit->body) << x << " " << y;
      lit[hit->body] += truth.light[0].lit.at(x, y);
    }
  EXPECT_GT(lit[0], 500);
  EXPECT_GT(seen[0], lit[0] + 500);
  EXPECT_GT(lit[1], 1000);
}

TEST(MeshBody, RefusesMeshesThatCannotBe) {
  Mesh mesh;
  mesh.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  mesh.uv = {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1)};
  mesh.triangles = {{0, 1, 2}};
  const auto made = [](const Mesh& from) { return TriangleMesh(std::make_shared<const Mesh>(from)); };
  const Body good{"it", made(mesh), Pose()};
  EXPECT_NEAR((point_at(good, Vec2(0.2, 0.3)) - Vec3(0.2, 0.3, 0)).norm(), 0, 1e-12);
  EXPECT_THROW(point_at(good, Vec2(0.7, 0.6)), std::invalid_argument);
  EXPECT_THROW(TriangleMesh(nullptr), std::invalid_argument);
  Mesh line = mesh;
  line.vertices[2] = Vec3(2, 0, 0);
  EXPECT_THROW(made(line), Error);
  Mesh wild = mesh;
  wild.vertices[1].x() = std::nan("");
  EXPECT_THROW(made(wild), Error);
  EXPECT_THROW(made(Mesh{}), Error);
  Room room;
  room.bodies = {good};
  room.bodies[0].cutout = Cutout{};
  EXPECT_THROW(nearest_hit(room, {Vec3(0, 0, -1), Vec3::UnitZ()}), std::invalid_argument);
}

}  // namespace
}  // namespace procam::simulate
