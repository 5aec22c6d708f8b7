#include "procam/room/calibrate_room.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "numeric_room.hpp"
#include "procam/room/deviations.hpp"

namespace procam::test {
namespace {

using room::RoomCalibration;
using room::RoomOptions;
using room::RoomPoints;

RoomOptions known_cameras(const NumericWorld& world) {
  RoomOptions options;
  for (int c = 0; c < int(world.cameras.size()); ++c)
    options.cameras[numeric_camera_name(world, c)] = {world.cameras[std::size_t(c)], {}};
  options.threads = 2;
  return options;
}

/// Two points that the first position sees of the first projector's light, far apart, and their true distance; known to half a
/// millimetre.
room::KnownDistance wall_distance(const NumericWorld& world, const RoomPoints& points) {
  int left = -1, right = -1;
  for (int i = 0; i < int(points.points.size()); ++i) {
    const room::LightReading& anchor = points.points[std::size_t(i)].readings[0];
    if (anchor.map != 0 || std::abs(anchor.camera_pixel.y() - 480) > 200) continue;
    const auto x = [&](int k) { return points.points[std::size_t(k)].readings[0].camera_pixel.x(); };
    if (left < 0 || x(i) < x(left)) left = i;
    if (right < 0 || x(i) > x(right)) right = i;
  }
  const auto at = [&](int i) { return *world.seen(0, points.points[std::size_t(i)].readings[0].camera_pixel); };
  return {{left, right}, {}, (at(left) - at(right)).norm(), 5e-4};
}

RoomCalibration solve(const NumericWorld& world, const RoomPoints& points, RoomOptions options) {
  if (options.distances.empty()) options.distances = {wall_distance(world, points)};
  return room::calibrate_room(points, options);
}

Rig true_rig(const NumericWorld& world) {
  Rig rig;
  for (std::size_t c = 0; c < world.cameras.size(); ++c)
    rig.cameras.push_back({numeric_camera_name(world, int(c)), world.cameras[c],
                           world.positions[c].rig_from_camera});  // the first view has each camera once
  rig.projectors = world.projectors;
  return rig;
}

double share_inside(const std::vector<room::ParameterDeviation>& deviations, double sigmas) {
  int inside = 0;
  for (const room::ParameterDeviation& d : deviations) inside += std::abs(d.sigmas()) < sigmas;
  return double(inside) / double(deviations.size());
}

/// RMS of the depths that the solved rig gives the exact light of the first map, metres.
double wall_error(const NumericWorld& world, const Rig& rig) {
  double sum = 0;
  int count = 0;
  const RigCamera& camera = rig.cameras[0];
  const RigProjector& projector = rig.projectors[0];
  const Pose projector_from_camera = projector.rig_from_projector.inverse() * camera.rig_from_camera;
  for (int y = 30; y < 960; y += 60)
    for (int x = 30; x < 1280; x += 60) {
      const auto light = world.light(0, 0, Vec2(x, y));
      if (!light) continue;
      const Vec3 truth = *world.seen(0, Vec2(x, y));
      const auto d = camera.camera.unproject(Vec2(x, y)), e = projector.projector.inverse_camera.unproject(*light);
      if (!d || !e) continue;
      const Vec3 a = e->cross(projector_from_camera.rotation * *d), b = e->cross(projector_from_camera.translation);
      const double range = -a.dot(b) / a.squaredNorm();
      sum += std::pow(range - truth.norm(), 2);
      ++count;
    }
  return std::sqrt(sum / std::max(1, count));
}

void expect_near_truth(const NumericWorld& world, const RoomCalibration& result) {
  const auto deviations = room::deviations(result.rig, true_rig(world));
  EXPECT_GE(share_inside(deviations, 3), 0.95);
  for (const room::ParameterDeviation& d : deviations)
    EXPECT_LT(std::abs(d.sigmas()), 4.5) << d.name << " off by " << d.off << ", sigma " << d.sigma;
  // Its mean square is that of the stated deviation with a few degrees of freedom: 3.5 times it once in 10 000.
  EXPECT_LT(wall_error(world, result.rig), 3.5 * result.wall_sigma_95);
}

TEST(CalibrateRoom, TwoCameraPositionsGiveTheProjectorsWholeLens) {
  const NumericWorld world = numeric_world(1, 2, 1);
  const RoomPoints points = read_points(world, 24, {0.05, 0.02, 3});
  const RoomCalibration result = solve(world, points, known_cameras(world));
  expect_near_truth(world, result);
  EXPECT_NEAR(result.rms_px, 0.05, 0.004);  // a reading of a depth that is fitted keeps its noise in the rows left
  EXPECT_NEAR(result.held_out_px, 0.05, 0.012);
  EXPECT_GT(result.outliers, 20);
  EXPECT_LT(wall_error(world, result.rig), 1.5e-3);
  EXPECT_LT(result.wall_sigma, 2e-3);
  EXPECT_FALSE(result.planar);
  EXPECT_FALSE(result.diagnostics.failed());
  ASSERT_EQ(result.positions.size(), 2u);
  const Pose off = result.positions[1].rig_from_camera * world.positions[1].rig_from_camera.inverse();
  EXPECT_LT(se3_log(off).norm(), 3e-3);
  EXPECT_GE(result.regions.size(), 9u);
}

TEST(CalibrateRoom, ExactLightGivesTheExactRig) {
  const NumericWorld world = numeric_world(1, 2, 1);
  const RoomPoints points = read_points(world, 30, {0, 0, 1});
  RoomOptions options = known_cameras(world);
  options.distances = {wall_distance(world, points)};
  options.distances[0].sigma = 0;
  const RoomCalibration result = room::calibrate_room(points, options);
  // The light is linear about a reading up to its curvature: some thousandths of a pixel.
  EXPECT_LT(wall_error(world, result.rig), 3e-4);
  EXPECT_LT(result.rms_px, 5e-3);
}

TEST(CalibrateRoom, ResultDoesNotDependOnTheThreads) {
  const NumericWorld world = numeric_world(1, 2, 1);
  const RoomPoints points = read_points(world, 40, {0.05, 0.02, 3});
  RoomOptions one = known_cameras(world), four = one;
  one.threads = 1;
  four.threads = 4;
  const Rig a = solve(world, points, one).rig, b = solve(world, points, four).rig;
  EXPECT_EQ(parameters_of(a.projectors[0].projector.inverse_camera), parameters_of(b.projectors[0].projector.inverse_camera));
  EXPECT_EQ(a.covariance.matrix, b.covariance.matrix);
}

TEST(CalibrateRoom, TwoCamerasAndTwoProjectors) {
  const NumericWorld world = numeric_world(2, 1, 2);
  const RoomCalibration result = solve(world, read_points(world, 30, {0.05, 0.02, 5}), known_cameras(world));
  expect_near_truth(world, result);
}

/// Each projector is seen by two neighbouring cameras alone.
TEST(CalibrateRoom, ChainOfFourCamerasAndThreeProjectors) {
  NumericWorld world = numeric_world(4, 1, 3);
  world.maps = {{0, 0}, {1, 0}, {1, 1}, {2, 1}, {2, 2}, {3, 2}};
  const RoomCalibration result = solve(world, read_points(world, 26, {0.05, 0.01, 6}), known_cameras(world));
  expect_near_truth(world, result);
}

/// A camera whose lens came from a board, with its covariance: the error of that lens is part of the result's.
TEST(CalibrateRoom, CarriesTheKnownLensCovariance) {
  const NumericWorld world = numeric_world(1, 2, 1);
  const RoomPoints points = read_points(world, 30, {0.05, 0.01, 8});
  RoomOptions options = known_cameras(world);
  const double exact = solve(world, points, options).wall_sigma;
  room::CameraLens& lens = options.cameras["camera"];
  lens.covariance.names = {"fx", "fy", "cx", "cy"};
  lens.covariance.matrix = MatX::Zero(4, 4);
  lens.covariance.matrix.diagonal() << 9, 9, 4, 4;
  lens.covariance.matrix(0, 1) = lens.covariance.matrix(1, 0) = 8.9;
  lens.lens.intrinsics.fx += 2.5;
  lens.lens.intrinsics.fy += 2.4;
  lens.lens.intrinsics.cx -= 1.5;
  const RoomCalibration result = solve(world, points, options);
  EXPECT_GT(result.wall_sigma, 1.2 * exact);
  expect_near_truth(world, result);
}

/// 12 seeds of 16 parameters: of 192 values, correlated within a seed, 95 % are inside 2.2 sigma; the mean square of their
/// deviations is one up to the few degrees of freedom.
TEST(CalibrateRoom, CovarianceIsThatOfManySeeds) {
  const NumericWorld world = numeric_world(1, 2, 1);
  std::vector<room::ParameterDeviation> all;
  for (unsigned seed = 20; seed < 32; ++seed) {
    const auto deviations = room::deviations(
        solve(world, read_points(world, 34, {0.05, 0.01, seed}), known_cameras(world)).rig, true_rig(world));
    all.insert(all.end(), deviations.begin(), deviations.end());
  }
  double square = 0;
  for (const room::ParameterDeviation& d : all) square += d.sigmas() * d.sigmas();
  EXPECT_GE(share_inside(all, 3), 0.95);
  EXPECT_LT(square / double(all.size()), 2.0);
  EXPECT_GT(square / double(all.size()), 0.15);  // priors of terms that the light hardly shows make some sigmas large
}

}  // namespace
}  // namespace procam::test
