#include "procam/room/calibrate_room.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "procam/room/deviations.hpp"
#include "room_cases.hpp"

namespace procam::test {
namespace {

using room::RoomCalibration;
using room::RoomOptions;
using room::RoomPoints;

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
  EXPECT_NEAR(result.rms_px, 0.05,
              0.004);  // a reading of a depth that is fitted keeps its noise in the rows left
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
  EXPECT_EQ(parameters_of(a.projectors[0].projector.inverse_camera),
            parameters_of(b.projectors[0].projector.inverse_camera));
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

/// The start and the search for outliers use a part of many points, the result all of them.
TEST(CalibrateRoom, OfManyPointsAllCount) {
  const NumericWorld world = numeric_world(2, 1, 2);
  const RoomPoints points = read_points(world, 10, {0.05, 0.02, 9});
  ASSERT_GT(points.points.size(), 10000u);
  const RoomCalibration result = solve(world, points, known_cameras(world));
  expect_near_truth(world, result);
  // One in ten is held out; of 2 % of the readings that are off each rejects its point.
  EXPECT_GT(result.points, 0.8 * double(points.points.size()));
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

/// 12 seeds of 16 parameters: of 192 values, correlated within a seed, 95 % are inside 2.2 sigma; the mean square of
/// their deviations is one up to the few degrees of freedom.
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
  EXPECT_GT(square / double(all.size()),
            0.15);  // priors of terms that the light barely shows make some sigmas large
}

/// Each light map off by a smooth field of its own, as decoded light is: neighbours share its error, and so do points that began
/// in other maps.
void bend(RoomPoints& points, double sigma, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  struct Wave {
    Vec2 by_pixel;
    double phase;
  };
  constexpr int kWaves = 6;
  std::vector<std::array<std::vector<Wave>, 2>> waves(points.maps.size());
  for (auto& map : waves)
    for (std::vector<Wave>& component : map)
      for (int k = 0; k < kWaves; ++k) {
        const double way = 2 * kPi * uniform(random), length = 180 + 200 * uniform(random);
        component.push_back(
            {2 * kPi / length * Vec2(std::cos(way), std::sin(way)), 2 * kPi * uniform(random)});
      }
  for (room::RoomPoint& point : points.points)
    for (room::LightReading& reading : point.readings)
      for (int c = 0; c < 2; ++c)
        for (const Wave& wave : waves[std::size_t(reading.map)][std::size_t(c)])
          reading.projector_pixel[c] += sigma * std::sqrt(2.0 / kWaves) *
                                        std::sin(wave.by_pixel.dot(reading.camera_pixel) + wave.phase);
}

/// Four seeds of 38 parameters. The mean square of their deviations would be one. With clusters by the map that a point began in
/// six seeds had 3.75, and 89 % inside three deviations.
TEST(CalibrateRoom, SmoothErrorsOfTheLightAreInTheCovariance) {
  const NumericWorld world = numeric_world(2, 1, 2);
  std::vector<room::ParameterDeviation> all;
  for (unsigned seed = 40; seed < 44; ++seed) {
    RoomPoints points = read_points(world, 34, {0.02, 0, seed});
    bend(points, 0.03, seed);
    const auto deviations = room::deviations(solve(world, points, known_cameras(world)).rig, true_rig(world));
    all.insert(all.end(), deviations.begin(), deviations.end());
  }
  double square = 0;
  for (const room::ParameterDeviation& d : all) square += d.sigmas() * d.sigmas();
  square /= double(all.size());
  EXPECT_GE(share_inside(all, 3), 0.95);
  EXPECT_LT(square, 2.0);
}

}  // namespace
}  // namespace procam::test
