/// Movements from given shifts: derivatives, the right cause, its covariance, the rate of false alarms of one test. No
/// images here. Noise has seeds; limits are at 4 sigma unless stated.
#include "procam/watch/movement.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

#include "watched_world.hpp"

namespace procam::watch {
namespace {

using test::corner;
using test::one_wall;
using test::watched_rig;
using test::WatchedWorld;
using test::WorldOptions;

constexpr double kNoise = 0.1;  // working pixels, an axis

WorldOptions walls(const std::vector<test::Wall>& list) {
  WorldOptions options;
  options.walls = list;
  return options;
}

LightGeometry geometry_of(const std::vector<test::Wall>& list) {
  const WatchedWorld world(walls(list));
  return light_geometry(world.rig().camera(), world.rig().projector(), world.surfaces());
}

/// Where the camera sees the light of the cell's projector pixel when projector and surface have moved: full models, in
/// working pixels.
Vec2 true_pixel(const LitCell& cell, const test::Wall& wall, const Vec6& projector_moved,
                const Vec6& wall_moved) {
  const Rig rig = watched_rig();
  const Ray ray = se3_exp(projector_moved) * rig.projector().rig_from_projector *
                  *rig.projector().projector.emit(cell.projector_pixel);
  const Vec3 point = *intersect(ray, Plane::of_xy(se3_exp(wall_moved) * wall.rig_from_surface));
  return *rig.camera().camera.project(rig.camera().rig_from_camera.inverse() * point);  // k = 1
}

std::vector<CellShift> shifts_of(const LightGeometry& geometry, const std::vector<test::Wall>& list,
                                 const Vec6& projector_moved, const std::vector<Vec6>& walls_moved,
                                 std::mt19937& random, double noise = kNoise) {
  std::normal_distribution<double> normal(0, 1);
  std::vector<CellShift> shifts;
  for (std::size_t i = 0; i < geometry.cells.size(); ++i) {
    const LitCell& cell = geometry.cells[i];
    const auto wall = std::size_t(cell.surface);
    CellShift& shift = shifts.emplace_back();
    shift.cell = int(i);
    shift.state = CellState::kMeasured;
    shift.shift = true_pixel(cell, list[wall], projector_moved, walls_moved[wall]) - cell.pixel +
                  noise * Vec2(normal(random), normal(random));
    shift.information = Mat2::Identity() / (kNoise * kNoise);
  }
  return shifts;
}

/// No systematic errors: the shifts have none.
MovementOptions exact() {
  MovementOptions options;
  options.cell_sigma = 1e-3;
  options.model_rotation = options.model_translation = 1e-9;
  options.surface_rotation = options.surface_translation = 1e-9;
  return options;
}

const std::vector<Vec6> kStill(2, Vec6::Zero());

TEST(LightGeometry, DerivativesAreThoseOfTheFullModels) {
  const auto list = corner();
  const LightGeometry geometry = geometry_of(list);
  ASSERT_GT(geometry.cells.size(), 40u);
  ASSERT_EQ(geometry.average, 1);
  for (const LitCell& cell : geometry.cells) {
    const test::Wall& wall = list[std::size_t(cell.surface)];
    EXPECT_NEAR((true_pixel(cell, wall, Vec6::Zero(), Vec6::Zero()) - cell.pixel).norm(), 0, 1e-6);
    for (int k = 0; k < 6; ++k) {
      const Vec6 step = 1e-5 * Vec6::Unit(k);
      const Vec2 by_projector = (true_pixel(cell, wall, step, Vec6::Zero()) -
                                 true_pixel(cell, wall, -step, Vec6::Zero())) /
                                2e-5,
                 by_wall = (true_pixel(cell, wall, Vec6::Zero(), step) -
                            true_pixel(cell, wall, Vec6::Zero(), -step)) /
                           2e-5;
      EXPECT_NEAR((cell.pixel_by_point * cell.by_projector().col(k) - by_projector).norm(), 0, 1e-2) << k;
      EXPECT_NEAR((cell.pixel_by_point * cell.by_surface().col(k) - by_wall).norm(), 0, 1e-2) << k;
    }
  }
}

TEST(LightGeometry, AveragedImagesKeepTheirPixelCentres) {
  Rig rig = watched_rig();
  Camera& camera = rig.cameras[0].camera;
  camera.size = {1280, 960};
  camera.intrinsics = {2 * camera.intrinsics.fx, 2 * camera.intrinsics.fy, 2 * camera.intrinsics.cx + 0.5,
                       2 * camera.intrinsics.cy + 0.5, 2 * camera.intrinsics.skew};
  const WatchedWorld world(walls(one_wall()));
  const LightGeometry fine = light_geometry(rig.camera(), rig.projector(), world.surfaces()),
                      coarse = geometry_of(one_wall());
  ASSERT_EQ(fine.average, 2);
  ASSERT_EQ(fine.cells.size(), coarse.cells.size());
  for (std::size_t i = 0; i < fine.cells.size(); ++i) {
    EXPECT_NEAR((fine.cells[i].projector_pixel - coarse.cells[i].projector_pixel).norm(), 0, 1e-6);
    EXPECT_NEAR((fine.cells[i].pixel_by_point - coarse.cells[i].pixel_by_point).norm(), 0, 1e-3);
  }
}

TEST(LightGeometry, ShadowsOfOtherSurfacesAreNotWatched) {
  auto list = one_wall();
  const std::size_t alone = geometry_of(list).cells.size();
  list.push_back({"sheet", Pose(so3_exp(Vec3(0, 0.1, 0)), Vec3(-0.2, -0.3, 1.5)), Vec2(0.3, 0.25)});
  const LightGeometry both = geometry_of(list);
  int on_sheet = 0;
  for (const LitCell& cell : both.cells) {
    on_sheet += cell.surface == 1;
    if (cell.surface == 1) continue;
    const Ray light = Ray{watched_rig().projector().rig_from_projector.translation, cell.ray_in_rig};
    const Ray own = list[1].rig_from_surface.inverse() * light;
    const Vec2 at = own.at(-own.origin.z() / own.direction.z()).head<2>();
    EXPECT_FALSE(at.x() > 0 && at.y() > 0 && at.x() < 0.3 && at.y() < 0.25);
  }
  EXPECT_GT(on_sheet, 0);
  EXPECT_LT(both.cells.size(), alone);
}

TEST(Movement, ABumpOfTheProjectorIsFoundWithItsSize) {
  const auto list = corner();
  const LightGeometry geometry = geometry_of(list);
  std::mt19937 random(5);
  const Vec6 bump = (Vec6() << 0.002, -0.003, 0.001, 0.001, -0.002, 0.0015).finished();
  const MovementEstimate estimate =
      estimate_movement(geometry, "projector", shifts_of(geometry, list, bump, kStill, random), exact());
  EXPECT_LT(estimate.probability, 1e-10);
  const Explanation& best = estimate.explanations.front();
  EXPECT_EQ(best.thing, MovedThing::kProjector);
  ASSERT_EQ(estimate.plausible().size(), 1u);
  const Vec6 off = best.moved - bump;
  EXPECT_LT(off.dot(best.covariance.ldlt().solve(off)), 30) << best.moved.transpose();  // 6 dof, 4e-5
  EXPECT_NEAR(best.error, 0.0066, 0.0025);  // 0.0036 rad at some 2 m, less what rolls
  EXPECT_LT(best.error_sigma, 3e-4);
}

TEST(Movement, CovarianceIsThatOfRepeatedMeasurements) {
  const auto list = corner();
  const LightGeometry geometry = geometry_of(list);
  std::mt19937 random(11);
  const Vec6 bump = (Vec6() << 0.001, -0.001, 0.0005, 0.001, 0, 0.001).finished();
  double chi2 = 0, false_alarms = 0, squares = 0;
  int degrees = 0;
  constexpr int kRuns = 150;
  for (int run = 0; run < kRuns; ++run) {
    const MovementEstimate moved =
        estimate_movement(geometry, "projector", shifts_of(geometry, list, bump, kStill, random), exact());
    for (const Explanation& one : moved.explanations)
      if (one.thing == MovedThing::kProjector) {
        const Vec6 off = one.moved - bump;
        chi2 += off.dot(one.covariance.ldlt().solve(off));
      }
    const MovementEstimate still = estimate_movement(
        geometry, "projector", shifts_of(geometry, list, Vec6::Zero(), kStill, random), exact());
    squares += still.chi2;
    degrees += still.degrees_of_freedom;
    false_alarms += still.probability < 0.05;
    EXPECT_EQ(still.explanations.front().thing, MovedThing::kNothing);
  }
  EXPECT_NEAR(chi2 / (6 * kRuns), 1, 4 * std::sqrt(2.0 / (6 * kRuns)) + 0.05);
  EXPECT_NEAR(squares / degrees, 1, 4 * std::sqrt(2.0 / degrees) + 0.05);
  // 5 % of 150: 7.5 +- 2.7.
  EXPECT_LT(false_alarms, 19);
  EXPECT_GT(false_alarms, 0);
}

TEST(Movement, OneOfTwoWallsIsNamed) {
  const auto list = corner();
  const LightGeometry geometry = geometry_of(list);
  std::mt19937 random(3);
  std::vector<Vec6> moved = kStill;
  // A rig that slides along the left wall, or turns about its normal, may look the same.
  const Vec3 turn(-0.004, 0.01, 0);
  moved[1] << turn, -turn.cross(list[1].rig_from_surface.translation);
  const MovementEstimate estimate = estimate_movement(
      geometry, "projector", shifts_of(geometry, list, Vec6::Zero(), moved, random), exact());
  const auto causes = estimate.plausible();
  ASSERT_FALSE(causes.empty());
  EXPECT_EQ(causes[0]->name, "right");
  EXPECT_EQ(causes[0]->thing, MovedThing::kSurface);
  for (const Explanation* one : causes) {
    EXPECT_NE(one->name, "projector");
    EXPECT_NE(one->name, "left");
  }
}

TEST(Movement, TheRigInACornerIsNamed) {
  const auto list = corner();
  const LightGeometry geometry = geometry_of(list);
  std::mt19937 random(4);
  const Vec6 rig = (Vec6() << 0.004, -0.006, 0.003, 0.012, 0.005, -0.009).finished();
  const MovementEstimate estimate = estimate_movement(
      geometry, "projector", shifts_of(geometry, list, Vec6::Zero(), {rig, rig}, random), exact());
  const auto causes = estimate.plausible();
  ASSERT_EQ(causes.size(), 1u);
  EXPECT_EQ(causes[0]->name, "rig");
}

TEST(Movement, OneWallAndTheRigCannotBeSeparated) {
  const auto list = one_wall();
  const LightGeometry geometry = geometry_of(list);
  std::mt19937 random(4);
  const Vec6 toward = (Vec6() << 0, 0.003, 0, 0, 0, 0.01).finished();
  const MovementEstimate estimate = estimate_movement(
      geometry, "projector", shifts_of(geometry, list, Vec6::Zero(), {toward}, random), exact());
  EXPECT_LT(estimate.probability, 1e-6);
  std::vector<std::string> names;
  for (const Explanation* one : estimate.plausible()) names.push_back(one->name);
  EXPECT_NE(std::find(names.begin(), names.end(), "wall"), names.end());
  EXPECT_NE(std::find(names.begin(), names.end(), "rig"), names.end());
}

TEST(Movement, CellsOnAPersonAreRejected) {
  const auto list = one_wall();
  const LightGeometry geometry = geometry_of(list);
  std::mt19937 random(8);
  auto shifts = shifts_of(geometry, list, Vec6::Zero(), kStill, random);
  std::uniform_real_distribution<double> anywhere(-8, 8);
  int wrong = 0;
  for (CellShift& shift : shifts) {
    const double x = geometry.cells[std::size_t(shift.cell)].pixel.x();
    if (x < 250 || x > 350) continue;
    shift.shift = Vec2(5 + 0.2 * anywhere(random), anywhere(random));
    ++wrong;
  }
  ASSERT_GT(wrong, 15);
  const MovementEstimate estimate = estimate_movement(geometry, "projector", shifts, exact());
  EXPECT_GE(estimate.rejected, wrong - 2);
  EXPECT_LE(estimate.rejected, wrong + 3);
  EXPECT_GT(estimate.probability, 1e-3);
}

/// Light that is seen later than assumed moves with the content; it is not taken for a movement.
TEST(Movement, ALateCameraIsNotAMovement) {
  const auto list = one_wall();
  const LightGeometry geometry = geometry_of(list);
  std::mt19937 random(9);
  auto shifts = shifts_of(geometry, list, Vec6::Zero(), kStill, random);
  constexpr double kLate = 0.005;
  for (CellShift& shift : shifts) {
    shift.by_delay = Vec2(90, 15);  // pixels a second
    shift.shift += kLate * shift.by_delay;
  }
  // A common speed looks like a rotation: content that moves otherwise in places separates them.
  for (std::size_t i = 0; i < shifts.size(); i += 3) {
    shifts[i].shift -= 2 * kLate * shifts[i].by_delay;
    shifts[i].by_delay = -shifts[i].by_delay;
  }
  const MovementEstimate estimate = estimate_movement(geometry, "projector", shifts, exact());
  EXPECT_NEAR(estimate.delay, kLate, 5e-4);
  EXPECT_GT(estimate.probability, 1e-3);
}

TEST(Movement, TooFewCellsSayNothing) {
  const LightGeometry geometry = geometry_of(one_wall());
  const MovementEstimate estimate = estimate_movement(geometry, "projector", {});
  EXPECT_EQ(estimate.degrees_of_freedom, 0);
  EXPECT_EQ(estimate.probability, 1);
}

TEST(Movement, TheRigsCovarianceIsThatOfProjectorAgainstCamera) {
  Rig rig = watched_rig();
  EXPECT_TRUE(projector_covariance(rig, "projector", "camera").isZero(0));
  rig.covariance.names = pose_increment_names("rig_from_projector");
  for (const std::string& name : pose_increment_names("rig_from_camera"))
    rig.covariance.names.push_back(name);
  const MatX root = MatX::Random(12, 12) * 1e-3;
  rig.covariance.matrix = root * root.transpose();
  MatX difference(6, 12);
  difference << MatX::Identity(6, 6), -MatX::Identity(6, 6);
  const Mat6 expected = difference * rig.covariance.matrix * difference.transpose();
  EXPECT_NEAR((projector_covariance(rig, "projector", "camera") - expected).norm(), 0, 1e-15);
}

/// Rank of what the light shows, relative to a movement of 1 mm and half a milliradian.
int directions_of(const Mat6& information) {
  Vec6 scale;
  scale << Vec3::Constant(5e-4), Vec3::Constant(1e-3);
  const Eigen::SelfAdjointEigenSolver<Mat6> eigen(
      Mat6(scale.asDiagonal() * information * scale.asDiagonal()));
  int count = 0;
  for (int k = 0; k < 6; ++k) count += eigen.eigenvalues()[k] > 1e-3 * eigen.eigenvalues()[5] ? 1 : 0;
  return count;
}

TEST(RigInformation, OnePlaneShowsThreeDirectionsAndTwoPlanesFive) {
  std::mt19937 random(4);
  const LightGeometry wall = geometry_of(one_wall()), two = geometry_of(corner());
  const RigInformation of_wall =
      rig_information(wall, shifts_of(wall, one_wall(), Vec6::Zero(), kStill, random), exact());
  const RigInformation of_corner =
      rig_information(two, shifts_of(two, corner(), Vec6::Zero(), kStill, random), exact());
  EXPECT_EQ(directions_of(of_wall.information), 3);
  EXPECT_EQ(directions_of(of_corner.information), 5);
  EXPECT_GT(of_wall.cells, 100);
  EXPECT_EQ(rig_information(wall, {}, exact()).cells, 0);
}

/// The score is that of the movement which the shifts were made with, in units of what the light shows.
TEST(RigInformation, ItsScoreIsThatOfTheTrueMovement) {
  std::mt19937 random(9);
  Vec6 moved;
  moved << 0.004, -0.012, 0.003, 0.011, -0.006, 0.017;
  const LightGeometry geometry = geometry_of(corner());
  const RigInformation found =
      rig_information(geometry, shifts_of(geometry, corner(), Vec6::Zero(), {moved, moved}, random), exact());
  const Eigen::SelfAdjointEigenSolver<Mat6> eigen(found.information);
  for (int k = 1; k < 6; ++k) {
    const Vec6 axis = eigen.eigenvectors().col(k);
    const double value = axis.dot(found.score) / eigen.eigenvalues()[k],
                 sigma = 1 / std::sqrt(eigen.eigenvalues()[k]);
    // 4 sigma, and 3 % for what is not linear.
    EXPECT_NEAR(value, axis.dot(moved), 4 * sigma + 0.03 * moved.norm()) << k;
  }
}

}  // namespace
}  // namespace procam::watch
