#include "procam/depth/plane_map.hpp"

#include <gtest/gtest.h>

#include <map>

#include "procam/simulate/drive.hpp"
#include "rooms.hpp"

namespace procam::depth {
namespace {

using simulate::Body;

/// A drive of six seconds through a room, ten frames a second, with what stands in it at each time.
struct Drive {
  simulate::DepthSensor sensor = test::lopsided_sensor({320, 240});
  simulate::Room room;
  std::map<std::string, std::vector<Points3>> corners;  ///< of each surface's content, by frame, world
  PlaneMap map;

  Drive() {
    using test::hung;
    room.bodies.push_back(hung("far", Vec3(0, 3.2, 1.3), Vec3(0, -1, 0), Vec2(4.4, 2.6), 0.6));
    room.bodies.push_back(hung("left", Vec3(-2.2, 1, 1.3), Vec3(1, 0, 0), Vec2(5, 2.6), 0.6));
    room.bodies.push_back(hung("right", Vec3(2.2, 1, 1.3), Vec3(-1, 0, 0), Vec2(5, 2.6), 0.6));
    room.bodies.push_back(hung("floor", Vec3(0, 1, 0), Vec3(0, 0, 1), Vec2(4.4, 5), 0.6));
    room.bodies.push_back(hung("table", Vec3(0.9, 2.5, 0.74), Vec3(0, 0, 1), Vec2(1.2, 0.7), 0.6, 0.1));
  }

  template <typename Things>
  void run(double position_sigma, double rotation_sigma, const Things& things_at) {
    const auto at = [](const Vec3& eye, const Vec3& target) { return test::looking_at(eye, target); };
    const simulate::Drive drive =
        simulate::drive_through({{at(Vec3(-0.4, 0.6, 1.2), Vec3(0, 3.2, 1.05)), 0},
                                 {at(Vec3(0.3, 1.1, 1.2), Vec3(0.2, 3.2, 1.05)), 3},
                                 {at(Vec3(-0.1, 0.8, 1.2), Vec3(-0.3, 3.2, 1.05)), 6}});
    simulate::Localiser localiser;
    localiser.rate = 10;
    localiser.delay = 0;
    localiser.position_sigma = position_sigma;
    localiser.rotation_sigma = rotation_sigma;
    localiser.seed = 3;
    const RayTable rays(sensor.camera);
    std::uint64_t frame = 0;
    for (const simulate::LocalisedPose& pose : simulate::localise(drive, localiser)) {
      simulate::Room now = room;
      for (const Body& body : things_at(pose.stamp)) now.bodies.push_back(body);
      const auto view = simulate::depth_view(now, sensor, pose.truth, ++frame);
      const DepthImage image(view.mm.view(), 0.001);
      // Position noise is in the world, rotation noise about the rig: as a left increment at the pose.
      Mat6 of_parts = Mat6::Zero(), turned = Mat6::Identity();
      of_parts.topLeftCorner<3, 3>() = rotation_sigma * rotation_sigma * Mat3::Identity();
      of_parts.bottomRightCorner<3, 3>() = position_sigma * position_sigma * Mat3::Identity();
      turned.bottomLeftCorner<3, 3>() = hat(pose.measured.translation);
      map.update(find_planes(image, rays), image, rays,
                 {pose.measured, turned * of_parts * turned.transpose()}, pose.stamp);
      for (const Surface& surface : map.surfaces().surfaces) {
        const auto& planar = std::get<PlanarSurface>(surface.geometry);
        Points3 points;
        for (const Vec2& p : planar.points)
          points.push_back(planar.frame_from_surface * Vec3(p.x(), p.y(), 0));
        corners[surface.name].push_back(points);
      }
    }
  }

  static double apart(const Points3& a, const Points3& b) {
    double most = 0;
    for (std::size_t i = 0; i < 4; ++i) most = std::max(most, (a[i] - b[i]).norm());
    return most;
  }
};

std::vector<Body> nothing(double) {
  return {};
}
std::vector<Body> block_at(const Vec3& place) {
  return simulate::box("block", Pose(Eigen::Quaterniond::Identity(), place), Vec3(0.45, 0.3, 1.75), 0.5);
}
/// Somebody walks past the wall, a metre a second.
std::vector<Body> passer_by(double time) {
  return time > 2 && time < 5.5 ? block_at(Vec3(-2 + (time - 2), 2.4, 0)) : std::vector<Body>();
}

TEST(PlaneMap, SurfacesKeepTheirNamesAndPlacesWhileDrivingAndWhileSomebodyPasses) {
  Drive drive;
  drive.run(0.005, 0.2 * kDegree, passer_by);
  ASSERT_EQ(drive.corners.count("wall_1"), 1u);
  ASSERT_EQ(drive.corners.count("table_1"), 1u);
  for (const auto& [name, frames] : drive.corners) {
    EXPECT_TRUE(name == "wall_1" || name == "table_1" || name == "floor") << name << " should not be";
    for (std::size_t i = 1; i < frames.size(); ++i)
      EXPECT_LT(Drive::apart(frames[i], frames[i - 1]), 0.003) << name << " in frame " << i;
  }
  // And where they are is right, to what poses of 5 mm and 0.2 degrees allow.
  for (const Vec3& p : drive.corners["wall_1"].back()) EXPECT_NEAR(p.y(), 3.2, 0.008);
  for (const Vec3& p : drive.corners["table_1"].back()) EXPECT_NEAR(p.z(), 0.74, 0.008);
}

TEST(PlaneMap, WhatStaysBeforeAWallShrinksItsContentUntilItLeaves) {
  Drive drive;
  double left = 1e9;
  drive.run(0, 0, [&](double time) {
    return time > 1.5 && time < left ? block_at(Vec3(0.2, 2.6, 0)) : nothing(0);
  });
  const auto& frames = drive.corners["wall_1"];
  ASSERT_GT(frames.size(), 40u);
  const auto area = [](const Points3& c) { return (c[1] - c[0]).norm() * (c[3] - c[0]).norm(); };
  EXPECT_LT(area(frames.back()), 0.8 * area(frames.front()));
  // All of it lies inside its first place.
  for (const Vec3& p : frames.back()) {
    EXPECT_GT(p.x(), frames.front()[0].x() - 0.005);
    EXPECT_LT(p.x(), frames.front()[1].x() + 0.005);
  }
  Drive again;
  left = 3;
  again.run(0, 0, [&](double time) {
    return time > 1.5 && time < left ? block_at(Vec3(0.2, 2.6, 0)) : nothing(0);
  });
  const auto& free_again = again.corners["wall_1"];
  EXPECT_LT(Drive::apart(free_again.back(), free_again.front()), 0.005);
}

TEST(PlaneMap, RefusesTimeThatGoesBackAndPosesThatAreNone) {
  const Camera camera{{64, 48}, {60, 61, 31, 24, 0}, NoDistortion{}};
  const RayTable rays(camera);
  const ImageF depth(camera.size, 1, 2.0f);
  const DepthImage image(depth.view());
  const Planes planes = find_planes(image, rays);
  PlaneMap map;
  map.update(planes, image, rays, {}, 1);
  EXPECT_THROW(map.update(planes, image, rays, {}, 0.5), std::invalid_argument);
  PoseWithCovariance nowhere;
  nowhere.pose.translation.x() = std::nan("");
  EXPECT_THROW(map.update(planes, image, rays, nowhere, 2), std::invalid_argument);
  EXPECT_THROW(map.update(planes, DepthImage(ImageF(64, 47)), rays, {}, 2), std::invalid_argument);
  EXPECT_TRUE(map.surfaces().surfaces.empty());
}

}  // namespace
}  // namespace procam::depth
