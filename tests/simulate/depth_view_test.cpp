#include "procam/simulate/depth_view.hpp"

#include <gtest/gtest.h>

#include "room_hit.hpp"
#include "rooms.hpp"

namespace procam::simulate {
namespace {

using test::hung;

DepthSensor lopsided_sensor() {
  DepthSensor sensor;
  sensor.camera = {{320, 250}, {293, 288, 151, 131, 0.4}, BrownConrady{{-0.05, 0.01, 0.0004, -0.0006, 0}}};
  sensor.emitter_in_camera = Vec3(-0.074, 0.003, 0.001);
  sensor.disparity_step = 0.0625;  // half the focal length of a real one, half the step
  return sensor;
}

/// A wall whose plane z = 0 is turned by `tilt`, its middle `distance` before the camera.
Room wall_at(double distance, double tilt) {
  Room room;
  room.bodies = {{"wall", Rectangle{Vec2(-4, -3), Vec2(4, 3)},
                  Pose(so3_exp(Vec3(0.3 * tilt, tilt, 0.2)), Vec3(0, 0, distance)), 0.6}};
  return room;
}

TEST(DepthView, TruthIsTheDepthOfTheSurface) {
  const DepthSensor sensor = lopsided_sensor();
  const Room room = test::lopsided_room();
  const Pose eye = test::room_from_camera();
  const DepthView view = depth_view(room, sensor, eye, 1);
  for (int y = 3; y < 250; y += 7)
    for (int x = 2; x < 320; x += 7) {
      const Ray ray = eye * Ray{Vec3::Zero(), *sensor.camera.unproject(Vec2(x, y))};
      const auto hit = nearest_hit(room, ray);
      ASSERT_EQ(view.body.at(x, y), hit ? hit->body : -1);
      if (!hit) continue;
      EXPECT_NEAR(view.true_metres.at(x, y), (eye.inverse() * hit->point_in_room).z(), 1e-6);
      EXPECT_NEAR(std::cos(view.angle.at(x, y)), -hit->normal_in_room.dot(ray.direction.normalized()), 1e-6);
    }
}

TEST(DepthView, NoiseFollowsTheLaw) {
  struct Case {
    double distance, tilt;
  };
  for (const Case& c : {Case{0.8, 0.1}, Case{1.7, 0.7}, Case{2.6, 0.3}, Case{2.0, 1.15}, Case{3.7, 0.05}}) {
    DepthSensor sensor = lopsided_sensor();
    const Room room = wall_at(c.distance, c.tilt);
    double sum = 0, sum2 = 0;
    int n = 0;
    for (int seed = 0; seed < 6; ++seed) {
      const DepthView view = depth_view(room, sensor, Pose(), std::uint64_t(seed));
      for (int y = 100; y < 160; ++y)
        for (int x = 120; x < 180; ++x) {
          if (!(view.metres.at(x, y) > 0)) continue;
          const double z = view.true_metres.at(x, y);
          const double error = (view.metres.at(x, y) - z) / axial_sigma(z, view.angle.at(x, y));
          sum += error;
          sum2 += error * error;
          ++n;
        }
    }
    ASSERT_GT(n, 21500);
    // Limits of 4.4 sigma, a false alarm in 1e5; and what remains of the rounding's phase: 1 % of sigma each.
    EXPECT_NEAR(sum / n, 0, 4.4 / std::sqrt(n) + 0.01) << c.distance;
    EXPECT_NEAR(sum2 / n, 1, 4.4 * std::sqrt(2.0 / n) + 0.02) << c.distance;
  }
}

TEST(DepthView, LawGrowsWithDistanceAndSlant) {
  EXPECT_NEAR(axial_sigma(0.4, 0), 0.0012, 1e-15);
  EXPECT_NEAR(axial_sigma(2.4, 0), 0.0088, 1e-15);
  EXPECT_NEAR(axial_sigma(4, 1.2), 0.0012 + 0.0019 * 3.6 * 3.6 + 0.00005 * 1.44 / std::pow(M_PI_2 - 1.2, 2),
              1e-15);
  EXPECT_NEAR(lateral_sigma(M_PI_4), 0.835, 1e-15);
}

TEST(DepthView, ReportsWholeStepsOfDisparityAndMillimetres) {
  DepthSensor sensor = lopsided_sensor();
  sensor.disparity_step = 0.25;
  const DepthView view = depth_view(wall_at(1.9, 0.4), sensor, Pose(), 3);
  const double steps = 293 * sensor.emitter_in_camera.norm() / 0.25;
  int holes = 0;
  for (int y = 0; y < 250; ++y)
    for (int x = 0; x < 320; ++x) {
      const double z = view.metres.at(x, y);
      EXPECT_EQ(view.mm.at(x, y), std::lround(1000 * z));
      if (z == 0) {
        ++holes;
        continue;
      }
      EXPECT_NEAR(steps / z, std::round(steps / z), 1e-4);
    }
  EXPECT_LT(holes, 0.2 * 320 * 250);
}

TEST(DepthView, HasHolesWhereTheEmittersLightDoesNotGetTo) {
  DepthSensor sensor = lopsided_sensor();
  sensor.axial_noise = sensor.edge_noise = sensor.disparity_step = 0;
  Room room = wall_at(2.4, 0.1);
  room.bodies.push_back({"post", Rectangle{Vec2(-0.1, -0.3), Vec2(0.15, 0.4)},
                         Pose(so3_exp(Vec3(0, 0, 0.1)), Vec3(0.1, 0, 1.1)), 0.5});
  const DepthView view = depth_view(room, sensor, Pose(), 1);
  int shadow = 0, seen = 0;
  for (int y = 1; y < 249; ++y)
    for (int x = 1; x < 319; ++x) {
      if (view.body.at(x, y) != 0) continue;
      const Vec3 bearing = *sensor.camera.unproject(Vec2(x, y));
      const Vec3 point = bearing * (view.true_metres.at(x, y) / bearing.z());
      const Vec3 out = point - sensor.emitter_in_camera;
      const auto first = nearest_hit(room, {sensor.emitter_in_camera, out});
      const bool hidden = first->lengths < 1 - 1e-4;
      EXPECT_EQ(view.metres.at(x, y) == 0, hidden) << x << " " << y;
      ++(hidden ? shadow : seen);
    }
  EXPECT_GT(shadow, 1000);  // a stripe beside the post
  EXPECT_GT(seen, 30000);
}

TEST(DepthView, HasHolesOutOfRangeAtGrazingAnglesAndByChance) {
  DepthSensor sensor = lopsided_sensor();
  sensor.axial_noise = sensor.edge_noise = sensor.disparity_step = 0;
  const auto holes = [&](const Room& room) {
    const DepthView view = depth_view(room, sensor, Pose(), 4);
    int count = 0;
    for (int y = 120; y < 140; ++y)
      for (int x = 140; x < 160; ++x) count += view.metres.at(x, y) == 0;
    return count;
  };
  EXPECT_EQ(holes(wall_at(2, 0.2)), 0);
  EXPECT_EQ(holes(wall_at(0.45, 0.2)), 400);
  EXPECT_EQ(holes(wall_at(4.9, 0.2)), 400);
  EXPECT_EQ(holes(wall_at(2, 1.42)), 400);
  sensor.dropout = 0.25;
  EXPECT_NEAR(holes(wall_at(2, 0.2)), 100, 4.4 * std::sqrt(400 * 0.25 * 0.75));  // 1e-5
}

TEST(DepthView, EdgesFrayByTheLateralLaw) {
  DepthSensor sensor = lopsided_sensor();
  sensor.camera.distortion = NoDistortion{};
  sensor.axial_noise = sensor.disparity_step = 0;
  sensor.emitter_in_camera = Vec3::Zero();  // no shadow
  Room room = wall_at(2.4, 0);
  room.bodies.push_back({"screen", Rectangle{Vec2(-3, -3), Vec2(0.1, 3)},
                         Pose(Eigen::Quaterniond::Identity(), Vec3(0, 0, 1.2)), 0.5});
  // Of a column at distance d from the edge, the share read on the other side is P(round(jitter) >= d).
  std::array<int, 9> across{};
  int rows = 0;
  const double edge = 293 * 0.1 / 1.2 + 151;  // skew moves it by 0.4 * y / f, below
  for (int seed = 0; seed < 20; ++seed) {
    const DepthView view = depth_view(room, sensor, Pose(), std::uint64_t(seed));
    for (int y = 20; y < 230; ++y, ++rows)
      for (int d = 0; d < 9; ++d) {
        const int x = int(std::floor(edge)) - 4 + d;
        across[std::size_t(d)] += view.metres.at(x, y) > 1.8;
      }
  }
  const double sigma = lateral_sigma(0.05);
  for (int d = 0; d < 9; ++d) {
    const double whole =
        std::floor(edge) + 0.5 - (std::floor(edge) - 4 + d);  // first column of the wall, less a half
    const double share = 0.5 * std::erfc(whole / sigma / std::sqrt(2.0));
    // 4.4 sigma, 1e-5; and 0.01 for the angle, which sigma knows only near the image's middle.
    EXPECT_NEAR(double(across[std::size_t(d)]) / rows, share,
                4.4 * std::sqrt(share * (1 - share) / rows) + 0.01)
        << d;
  }
}

TEST(DepthView, EqualSeedsGiveEqualViewsForAnyNumberOfThreads) {
  const DepthSensor sensor = lopsided_sensor();
  const Room room = test::lopsided_room();
  const auto pixels = [&](std::uint64_t seed, int threads) {
    const DepthView view = depth_view(room, sensor, test::room_from_camera(), seed, threads);
    return std::vector<std::uint16_t>(view.mm.data(), view.mm.data() + 320 * 250);
  };
  EXPECT_EQ(pixels(3, 1), pixels(3, 2));
  EXPECT_NE(pixels(3, 1), pixels(4, 1));
}

TEST(DepthView, ReadAgainIsTheViewOfTheOtherSeed) {
  DepthSensor sensor = lopsided_sensor();
  const Room room = test::lopsided_room();
  const DepthView first = depth_view(room, sensor, test::room_from_camera(), 3),
                  expected = depth_view(room, sensor, test::room_from_camera(), 4),
                  again = read_again(first, sensor, 4);
  int differ = 0, shadowed = 0;
  for (int y = 0; y < again.mm.height(); ++y)
    for (int x = 0; x < again.mm.width(); ++x) {
      ASSERT_EQ(again.mm.at(x, y), expected.mm.at(x, y)) << x << " " << y;
      ASSERT_EQ(again.true_metres.at(x, y), first.true_metres.at(x, y)) << x << " " << y;
      differ += again.mm.at(x, y) != first.mm.at(x, y);
      if (again.shadowed.at(x, y) == 0) continue;
      ++shadowed;
      ASSERT_EQ(first.shadowed.at(x, y), 1) << x << " " << y;
    }
  EXPECT_GT(differ, 1000);
  EXPECT_GT(shadowed, 100);
  sensor.camera.size = {321, 250};
  EXPECT_THROW(read_again(first, sensor, 4), std::invalid_argument);
}

TEST(DepthView, RefusesNumbersOutOfRange) {
  const auto view = [](const auto& change) {
    DepthSensor sensor = lopsided_sensor();
    change(sensor);
    return depth_view(wall_at(2, 0), sensor, Pose(), 1);
  };
  EXPECT_THROW(view([](DepthSensor& s) { s.nearest = 5; }), std::invalid_argument);
  EXPECT_THROW(view([](DepthSensor& s) { s.axial_noise = -1; }), std::invalid_argument);
  EXPECT_THROW(view([](DepthSensor& s) { s.dropout = 1.1; }), std::invalid_argument);
  EXPECT_THROW(view([](DepthSensor& s) { s.emitter_in_camera.setZero(); }), std::invalid_argument);
}

}  // namespace
}  // namespace procam::simulate
