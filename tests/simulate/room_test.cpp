#include "procam/simulate/room.hpp"

#include <gtest/gtest.h>

#include "../support/lopsided.hpp"
#include "procam/core/surface/surface.hpp"
#include "room_hit.hpp"
#include "rooms.hpp"

namespace procam::simulate {
namespace {

using procam::test::lopsided_pose;
using procam::test::random_vec3;
using procam::test::uniform;

/// Bilinear in u and v by pieces, all of 0..1.
std::shared_ptr<const Mesh> bent_sheet() {
  GridSurface sheet;
  sheet.columns = 3;
  sheet.rows = 2;
  sheet.points = {{-0.3, -0.2, 0.1}, {0.1, -0.25, 0},   {0.4, -0.2, 0.2},
                  {-0.3, 0.3, 0},    {0.12, 0.33, 0.1}, {0.5, 0.3, 0.3}};
  return mesh_of(Surface{"sheet", sheet, {}, ""});
}

/// One body of every shape, whole and in part.
std::vector<Body> every_shape() {
  const Pose place = lopsided_pose();
  return {{"rectangle", Rectangle{Vec2(-0.3, -0.1), Vec2(0.4, 0.5)}, place},
          {"polygon", Polygon{{Vec2(-0.3, -0.1), Vec2(0.5, 0.1), Vec2(0.4, 0.5), Vec2(0.05, 0.15)}}, place},
          {"sphere", Sphere{0.37}, place},
          {"dome", Sphere{0.37, {-0.4, 2.2}, {0.2, 1.3}}, place},
          {"tube", Cylinder{0.21, -0.3, 0.4}, place},
          {"niche", Cylinder{0.21, -0.3, 0.4, {2.1, 4.4}}, place},
          {"mesh", TriangleMesh(bent_sheet()), place}};
}

TEST(Room, FindsAgainThePointOfEveryUv) {
  std::mt19937_64 random(3);
  for (const Body& body : every_shape()) {
    Room room;
    room.bodies = {body};
    int found = 0;
    for (int i = 0; i < 200; ++i) {
      const Vec2 uv(uniform(random, 0.01, 0.99), uniform(random, 0.01, 0.99));
      const Vec3 point = point_at(body, uv), eye = point + random_vec3(random, 1e-5);
      const auto hit = nearest_hit(room, {eye, point - eye});
      if (!hit) {  // of a polygon's bounds only a part
        EXPECT_EQ(body.name, "polygon");
        continue;
      }
      ++found;
      EXPECT_NEAR(hit->lengths, 1, 1e-6) << body.name;
      EXPECT_NEAR((hit->point_in_room - point).norm(), 0, 1e-12) << body.name;
      EXPECT_NEAR((hit->uv - uv).norm(), 0, 1e-9) << body.name;
      EXPECT_NEAR(hit->normal_in_room.norm(), 1, 1e-12);
      EXPECT_LT(hit->normal_in_room.dot(point - eye), 0);
    }
    EXPECT_GT(found, body.name == "polygon" ? 60 : 199) << body.name;
  }
}

TEST(Room, NormalsStandOnSpheresAndTubes) {
  Room room;
  room.bodies = {{"ball", Sphere{0.5}, Pose(so3_exp(Vec3(0.3, 1, 0.2)), Vec3(0.2, 0.1, 2))}};
  const auto hit = nearest_hit(room, {Vec3(0.1, 0.3, 0), Vec3(0.02, -0.1, 0.9)});
  ASSERT_TRUE(hit);
  EXPECT_TRUE(hit->front);
  EXPECT_NEAR((hit->normal_in_room - (hit->point_in_room - Vec3(0.2, 0.1, 2)) / 0.5).norm(), 0, 1e-12);
  const auto inside = nearest_hit(room, {Vec3(0.2, 0.1, 2.1), Vec3(0.3, 0.2, 0.9)});
  ASSERT_TRUE(inside);
  EXPECT_FALSE(inside->front);
  EXPECT_NEAR((inside->normal_in_room + (inside->point_in_room - Vec3(0.2, 0.1, 2)) / 0.5).norm(), 0, 1e-12);
}

TEST(Room, SeesASphereInItsTangentConeAlone) {
  const Vec3 centre(0.4, -0.3, 2.2), eye(-0.1, 0.2, 0.3);
  Room room;
  room.bodies = {{"ball", Sphere{0.6}, Pose(so3_exp(Vec3(0.3, 1, 0.2)), centre)}};
  const Vec3 axis = (centre - eye).normalized(), side = axis.cross(Vec3(0.3, 1, 0.1)).normalized();
  const double half = std::asin(0.6 / (centre - eye).norm());
  for (double around = 0; around < 6.2; around += 0.3) {
    const Vec3 out = Eigen::AngleAxisd(around, axis) * side;
    const auto ray = [&](double angle) {
      return Ray{eye, Vec3(std::cos(angle) * axis + std::sin(angle) * out)};
    };
    EXPECT_TRUE(nearest_hit(room, ray(half - 1e-9)));
    EXPECT_FALSE(nearest_hit(room, ray(half + 1e-9)));
  }
}

TEST(Room, ShowsTheNearestAndOfOnePlaneTheLater) {
  Room room;
  room.bodies = {
      {"near", Rectangle{Vec2(-1, -1), Vec2(0, 1)}, Pose(so3_exp(Vec3(0.2, 0.1, 0)), Vec3(0, 0, 1))},
      {"wall", Rectangle{Vec2(-3, -3), Vec2(3, 3)}, Pose(so3_exp(Vec3(0.1, 0, 0.3)), Vec3(0, 0, 2))},
      {"sheet", Rectangle{Vec2(-0.2, -0.2), Vec2(0.3, 0.2)},
       Pose(so3_exp(Vec3(0.1, 0, 0.3)), Vec3(0, 0, 2))}};
  EXPECT_EQ(nearest_hit(room, {Vec3::Zero(), Vec3(-0.1, 0.02, 1)})->body, 0);
  EXPECT_EQ(nearest_hit(room, {Vec3::Zero(), Vec3(0.1, 0.02, 1)})->body, 2);
  EXPECT_EQ(nearest_hit(room, {Vec3::Zero(), Vec3(0.5, 0.02, 1)})->body, 1);
  EXPECT_FALSE(nearest_hit(room, {Vec3::Zero(), Vec3(0.5, 0.02, -1)}));
  EXPECT_EQ(room.index_of("wall"), 1);
  EXPECT_THROW(room.index_of("floor"), Error);
}

TEST(Room, IsSeenThroughASlitThatIsThinnerThanAPixel) {
  Room room;
  room.ambient = 1;
  // A comb: the slit from the right leaves the corners of most cells on the polygon.
  room.bodies = {
      {"wall", Rectangle{Vec2(-3, -3), Vec2(3, 3)}, Pose(so3_exp(Vec3(0.1, 0, 0.3)), Vec3(0, 0, 2))},
      {"comb",
       Polygon{{Vec2(-0.6, -0.5), Vec2(0.6, -0.5), Vec2(0.6, -0.0008), Vec2(-0.5, 0), Vec2(0.6, 0.0008),
                Vec2(0.6, 0.5), Vec2(-0.6, 0.5)}},
       Pose(so3_exp(Vec3(0.2, 0.1, 0.4)), Vec3(0, 0, 1))}};
  const Camera camera = test::room_camera();
  const RoomTruth truth = room_view(room, camera, Pose(), {}).truth;
  int through = 0, wrong = 0;
  for (int y = 100; y < 412; ++y)
    for (int x = 100; x < 540; ++x) {
      const auto hit = nearest_hit(room, {Vec3::Zero(), *camera.unproject(Vec2(x, y))});
      const Vec3 on_comb = room.bodies[1].room_from_body.inverse() * hit->point_in_room;
      through += hit->body == 0 && std::abs(on_comb.x()) < 0.5 && std::abs(on_comb.y()) < 0.4;
      wrong += truth.body.at(x, y) != hit->body;
    }
  EXPECT_GT(through, 50);
  EXPECT_LT(wrong, 10);  // rays that pass within 1e-3 px of the rim
}

TEST(Room, ABoxIsClosedAndReadsFromOutside) {
  const Pose room_from_box = lopsided_pose();
  const Vec3 size(0.3, 0.7, 0.2);
  Room room;
  room.bodies = box("parcel", room_from_box, size, 0.5);
  std::mt19937_64 random(5);
  for (int i = 0; i < 300; ++i) {
    const Vec3 inside = room_from_box * Vec3(0.5 * size + 0.49 * random_vec3(random, 1).cwiseProduct(size));
    const Vec3 direction = random_vec3(random, 1);
    const auto out = nearest_hit(room, {inside, direction});
    ASSERT_TRUE(out);
    EXPECT_FALSE(out->front);
    const auto in = nearest_hit(room, {inside + 5 * direction.normalized(), -direction});
    ASSERT_TRUE(in);
    EXPECT_TRUE(in->front);
    EXPECT_EQ(in->body, out->body);
  }
  EXPECT_EQ(room.bodies[5].name, "parcel +z");
}

TEST(Room, RefusesBodiesThatCannotBe) {
  const auto meet_with = [](const Shape& shape) {
    Room room;
    room.bodies = {{"it", shape, Pose()}};
    return nearest_hit(room, {Vec3(0, 0, -1), Vec3::UnitZ()});
  };
  EXPECT_THROW(meet_with(Rectangle{Vec2(0, 0), Vec2(0, 1)}), std::invalid_argument);
  EXPECT_THROW(meet_with(Polygon{{Vec2(0, 0), Vec2(0, 1)}}), std::invalid_argument);
  EXPECT_THROW(meet_with(Sphere{-1}), std::invalid_argument);
  EXPECT_THROW(meet_with(Cylinder{1, 1, 0}), std::invalid_argument);
  EXPECT_THROW(meet_with(Cylinder{1, 0, 1, {0, 7}}), std::invalid_argument);
  EXPECT_THROW(box("it", Pose(), Vec3(1, 0, 1), 0.5), std::invalid_argument);
  EXPECT_THROW(marker_sheet({2, 0.1, Pose()}, test::some_codes()), std::invalid_argument);
  EXPECT_THROW(point_at({"it", Sphere{1}, Pose()}, Vec2(1.1, 0)), std::invalid_argument);
}

}  // namespace
}  // namespace procam::simulate
