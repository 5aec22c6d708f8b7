/// A plane by the light of the rig's projector: numbers alone, no images.
#include "procam/track/sight_plane.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <random>

#include "procam/core/base/detail/chi_square.hpp"
#include "procam/core/geometry/plane.hpp"
#include "support/expect_error.hpp"
#include "support/lopsided.hpp"

namespace procam::track {
namespace {

RigCamera seeing_camera() {
  RigCamera camera;
  camera.camera = {{640, 480}, {640, 633, 322, 251, 0.4}, BrownConrady{{-0.17, 0.05, 0.0009, -0.0006, 0}}};
  camera.rig_from_camera = test::lopsided_pose();
  return camera;
}
/// 0.3 m beside the camera; its axis leaves the frame's middle.
RigProjector lopsided_projector() {
  RigProjector projector;
  projector.projector.inverse_camera = {
      {1024, 768}, {1490, 1478, 530, 702, -0.8}, BrownConrady{{-0.04, 0.01, -0.0005, 0.0006, 0}}};
  projector.rig_from_projector =
      test::lopsided_pose() * Pose(so3_exp(Vec3(-0.11, -0.10, 0.02)), Vec3(0.31, 0.05, 0.03));
  return projector;
}
/// Of a plane that the camera sees 2 m away, tilted.
Plane plane_in_rig(double tilt = 0.3, double distance = 2.1) {
  return test::lopsided_pose() *
         Plane::through(Vec3(0.05, -0.1, distance), Vec3(-std::sin(tilt), 0.2, -std::cos(tilt)));
}

/// The camera pixel where the light of a projector pixel falls, by the formulas of core alone.
Vec2 seen_on(const Plane& plane, const Vec2& projector_pixel, const RigCamera& camera,
             const RigProjector& projector) {
  const Ray light = projector.rig_from_projector * *projector.projector.emit(projector_pixel);
  return *camera.camera.project(camera.rig_from_camera.inverse() * *intersect(light, plane));
}

/// 9 x 7 pixels over the projector's frame, exact.
std::vector<LightPoint> points_on(const Plane& plane, const RigCamera& camera = seeing_camera(),
                                  const RigProjector& projector = lopsided_projector()) {
  std::vector<LightPoint> points;
  for (int row = 0; row < 7; ++row)
    for (int column = 0; column < 9; ++column) {
      LightPoint point;
      point.projector_pixel = Vec2(60 + 111.3 * column, 50 + 108.7 * row);
      point.camera_pixel = seen_on(plane, point.projector_pixel, camera, projector);
      // No two alike, none round.
      point.camera_covariance << 0.010 + 0.002 * column, 0.003, 0.003, 0.008 + 0.003 * row;
      points.push_back(point);
    }
  return points;
}

PlaneSighting sight(const std::vector<LightPoint>& points, const SightPlaneOptions& options = {}) {
  return sight_plane(points, seeing_camera(), lopsided_projector(), options);
}

/// Tilt about x and y, and z, of the true plane in the frame of the one found.
Vec3 error_of(const PlaneSighting& seen, const Plane& truth) {
  const Plane found = seen.plane_from_rig.pose * truth;
  const Vec3 normal = found.normal.z() < 0 ? Vec3(-found.normal) : found.normal;
  const double offset = found.normal.z() < 0 ? -found.offset : found.offset;
  return Vec3(normal.y(), -normal.x(), offset);
}

Mat3 counting(const Mat6& covariance) {
  const int rows[] = {0, 1, 5};
  Mat3 block;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) block(i, k) = covariance(rows[i], rows[k]);
  return block;
}

std::vector<LightPoint> with_noise(std::vector<LightPoint> points, std::uint64_t seed, double factor = 1) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (LightPoint& point : points) {
    const Mat2 lower = point.camera_covariance.llt().matrixL();
    const double a = normal(random), b = normal(random);
    point.camera_pixel += factor * lower * Vec2(a, b);
  }
  return points;
}

TEST(SightPlane, ExactPointsGiveTheExactPlane) {
  for (const double tilt : {-0.6, 0.0, 0.3, 0.8}) {
    const Plane truth = plane_in_rig(tilt);
    const PlaneSighting seen = sight(points_on(truth));
    EXPECT_LT(error_of(seen, truth).norm(), 1e-9) << tilt;
    EXPECT_EQ(seen.used, 63);
    EXPECT_TRUE(seen.rejected.empty());
    EXPECT_LT(seen.chi2_per_dof, 1e-9);
    EXPECT_LT(seen.across_px, 1e-6);
    // z points to the camera; the origin is in the middle of the light.
    const Pose& plane_from_rig = seen.plane_from_rig.pose;
    EXPECT_GT((plane_from_rig * seeing_camera().rig_from_camera.translation).z(), 1);
    Vec3 middle = Vec3::Zero();
    for (const LightPoint& point : points_on(truth))
      middle += *intersect(lopsided_projector().rig_from_projector *
                               *lopsided_projector().projector.emit(point.projector_pixel),
                           truth) /
                63;
    EXPECT_LT((plane_from_rig * middle).norm(), 1e-8);
    EXPECT_NEAR(plane_from_rig.rotation_matrix().determinant(), 1, 1e-12);
    for (const int arbitrary : {2, 3, 4}) EXPECT_EQ(seen.plane_from_rig.covariance(arbitrary, arbitrary), 1);
  }
}

TEST(SightPlane, TheOrderOfThePointsDoesNotMatter) {
  const Plane truth = plane_in_rig();
  std::vector<LightPoint> points = points_on(truth);
  std::mt19937_64 random(5);
  for (int order = 0; order < 12; ++order) {
    std::shuffle(points.begin(), points.end(), random);
    const PlaneSighting seen = sight(points);
    EXPECT_LT(error_of(seen, truth).norm(), 1e-9);
    EXPECT_GT((seen.plane_from_rig.pose * seeing_camera().rig_from_camera.translation).z(), 1);
  }
}

TEST(SightPlane, TheCovarianceIsThatOfDerivativesByDifferences) {
  const Plane truth = plane_in_rig();
  const std::vector<LightPoint> points = points_on(truth);
  const PlaneSighting seen = sight(points);
  const int counting_rows[] = {0, 1, 5};
  Mat3 information = Mat3::Zero();
  for (const LightPoint& point : points) {
    Eigen::Matrix<double, 2, 3> jacobian;
    for (int i = 0; i < 3; ++i) {
      constexpr double kStep = 1e-6;
      Vec6 increment = Vec6::Zero();
      increment[counting_rows[i]] = kStep;
      const auto pixel_at = [&](const Vec6& xi) {
        const Pose plane_from_rig = se3_exp(xi) * seen.plane_from_rig.pose;
        return seen_on(Plane::of_xy(plane_from_rig.inverse()), point.projector_pixel, seeing_camera(),
                       lopsided_projector());
      };
      jacobian.col(i) = (pixel_at(increment) - pixel_at(-increment)) / (2 * kStep);
    }
    information += jacobian.transpose() * point.camera_covariance.inverse() * jacobian;
  }
  const Mat3 expected = information.inverse(), found = counting(seen.plane_from_rig.covariance);
  EXPECT_LT((found - expected).norm(), 1e-6 * expected.norm()) << found << "\n\n" << expected;
}

TEST(SightPlane, FourHundredSeedsAreAsFarOffAsStated) {
  const Plane truth = plane_in_rig();
  const std::vector<LightPoint> points = points_on(truth);
  constexpr int kSeeds = 400;
  double sum = 0, chi2 = 0;
  int used = 0, beyond = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const PlaneSighting seen = sight(with_noise(points, std::uint64_t(seed)));
    const double factor = std::max(1.0, seen.chi2_per_dof);  // as the covariance has it
    const Vec3 error = error_of(seen, truth);
    const double square = factor * error.dot(counting(seen.plane_from_rig.covariance).ldlt().solve(error));
    sum += square;
    beyond += square > internal::chi_square_limit(0.05, 3);
    chi2 += seen.chi2_per_dof * (2 * seen.used - 3);
    used += seen.used;
  }
  // Chi-square of 1200 degrees of freedom: within 4 standard deviations but for 1 set of seeds of 16 000.
  EXPECT_NEAR(sum, 3 * kSeeds, 4 * std::sqrt(2.0 * 3 * kSeeds));
  // 5 % of 400, within 4 standard deviations as well.
  EXPECT_NEAR(beyond, 20, 4 * std::sqrt(400 * 0.05 * 0.95));
  // One point of 10 000 is rejected, 2.5 in all; more than 12 in 1 set of seeds of 100 000.
  EXPECT_GE(used, kSeeds * 63 - 12);
  EXPECT_NEAR(chi2 / (kSeeds * 123), 1, 0.02);  // 3 standard deviations, and what the rejected ones lack
}

TEST(SightPlane, NoiseAboveTheStatedOneCounts) {
  const Plane truth = plane_in_rig();
  double sum = 0;
  constexpr int kSeeds = 100;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const PlaneSighting seen = sight(with_noise(points_on(truth), std::uint64_t(seed), 2.5));
    EXPECT_GE(seen.used, 58);
    const Vec3 error = error_of(seen, truth);
    sum += error.dot(counting(seen.plane_from_rig.covariance).ldlt().solve(error));
  }
  EXPECT_NEAR(sum, 3 * kSeeds, 4 * std::sqrt(2.0 * 3 * kSeeds));
}

/// A corner of a room: from a column on, the light falls on another wall.
std::vector<LightPoint> points_in_corner(int columns_on_first, const Plane& first, const Plane& second) {
  std::vector<LightPoint> points = points_on(first), others = points_on(second);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (int(i % 9) >= columns_on_first) points[i] = others[i];
  return points;
}

TEST(SightPlane, InACornerTheLargerPlaneRemains) {
  const Plane first = plane_in_rig(0.3), second = plane_in_rig(-0.9, 2.4);
  const std::vector<LightPoint> points = with_noise(points_in_corner(6, first, second), 3);
  const PlaneSighting seen = sight(points);
  EXPECT_EQ(seen.used + int(seen.rejected.size()), 63);
  EXPECT_GE(seen.used, 41);
  // Chi-square of 3: 21.1 but for 1 in 10 000.
  const Vec3 off = error_of(seen, first);
  EXPECT_LT(off.dot(counting(seen.plane_from_rig.covariance).ldlt().solve(off)), 21.1);
  for (const std::size_t i : seen.rejected) EXPECT_GE(i % 9, 6u) << i;
  // Of 63 points 35 are 56 %.
  EXPECT_ERROR(sight(points_in_corner(5, first, second)), kDegenerate, "corner");
  EXPECT_ERROR(sight(with_noise(points_in_corner(5, first, second), 4)), kDegenerate, "corner");
}

TEST(SightPlane, WrongPointsAreRejected) {
  const Plane truth = plane_in_rig();
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    std::mt19937_64 random(seed + 77);
    std::vector<LightPoint> points = with_noise(points_on(truth), seed);
    for (std::size_t i = 0; i < points.size(); i += 4)
      points[i].camera_pixel += Vec2(test::uniform(random, 3, 60), test::uniform(random, -60, -3));
    const PlaneSighting seen = sight(points);
    for (std::size_t i = 0; i < points.size(); i += 4)
      EXPECT_TRUE(std::find(seen.rejected.begin(), seen.rejected.end(), i) != seen.rejected.end()) << i;
    EXPECT_GE(seen.used, 45);
    const Vec3 error = error_of(seen, truth);
    EXPECT_LT(error.dot(counting(seen.plane_from_rig.covariance).ldlt().solve(error)), 21.1) << seed;
  }
}

TEST(SightPlane, FourPointsAreEnough) {
  const Plane truth = plane_in_rig();
  const std::vector<LightPoint> all = points_on(truth);
  std::vector<LightPoint> points = {all[0], all[8], all[54], all[62]};
  EXPECT_LT(error_of(sight(points), truth).norm(), 1e-9);
  points.pop_back();
  EXPECT_ERROR(sight(points), kNotEnoughData, "3 points of 3");
  EXPECT_ERROR(sight({}), kNotEnoughData, "4 are needed");
}

TEST(SightPlane, DegenerateViewsAreRefusedWithTheCause) {
  const Plane truth = plane_in_rig();
  const std::vector<LightPoint> all = points_on(truth);
  const std::vector<LightPoint> row(all.begin() + 9, all.begin() + 18);
  EXPECT_ERROR(sight(row), kDegenerate, "on a line");
  EXPECT_ERROR(sight(with_noise(row, 5)), kDegenerate, "on a line");

  RigProjector at_the_camera = lopsided_projector();
  at_the_camera.rig_from_projector.translation =
      seeing_camera().rig_from_camera.translation + Vec3(2e-4, -1e-4, 3e-4);
  EXPECT_ERROR(sight_plane(points_on(truth, seeing_camera(), at_the_camera), seeing_camera(), at_the_camera),
               kDegenerate, "no baseline");

  // A small part of the frame: the tilt is not determined.
  std::vector<LightPoint> few = {all[30], all[31], all[39], all[40]};
  for (LightPoint& point : few) point.camera_covariance *= 400;
  EXPECT_ERROR(sight(few), kDegenerate, "standard deviation");

  // A plane along the projector's rays.
  const RigProjector projector = lopsided_projector();
  const Pose rig_from_projector = projector.rig_from_projector;
  const Vec3 middle = projector.projector.emit(Vec2(512, 384))->direction;
  const Vec3 normal = middle.cross(Vec3(0.1, 1, 0)).normalized();
  const Plane grazing =
      rig_from_projector * Plane::through(2 * middle + 0.02 * normal, normal - 0.005 * middle);
  std::vector<LightPoint> lit;
  for (int row_number = 0; row_number < 12; ++row_number)
    for (int i = 0; i < 6; ++i) {
      LightPoint point;
      point.projector_pixel = Vec2(500 - 3.5 * i, 200 + 40 * row_number);
      const auto met =
          intersect(rig_from_projector * *projector.projector.emit(point.projector_pixel), grazing);
      if (!met) continue;
      const auto pixel = seeing_camera().camera.project(seeing_camera().rig_from_camera.inverse() * *met);
      if (!pixel) continue;
      point.camera_pixel = *pixel;
      lit.push_back(point);
    }
  ASSERT_GT(lit.size(), 20u);
  EXPECT_ERROR(sight(lit), kDegenerate, "edge-on");
}

TEST(SightPlane, AnotherRigIsNamedAsTheCause) {
  const std::vector<LightPoint> points = points_on(plane_in_rig());
  RigProjector moved = lopsided_projector();
  moved.rig_from_projector = moved.rig_from_projector * Pose(so3_exp(Vec3(0.02, 0, 0)), Vec3::Zero());
  EXPECT_ERROR(sight_plane(points, seeing_camera(), moved), kDegenerate, "epipolar");
}

TEST(SightPlane, WhatIsNotFiniteIsInvalid) {
  const std::vector<LightPoint> points = points_on(plane_in_rig());
  const double nan = std::nan("");
  std::vector<LightPoint> broken = points;
  broken[4].camera_pixel.x() = nan;
  EXPECT_THROW(sight(broken), std::invalid_argument);
  broken = points;
  broken[4].projector_pixel.y() = INFINITY;
  EXPECT_THROW(sight(broken), std::invalid_argument);
  broken = points;
  broken[4].camera_covariance(0, 1) = nan;
  EXPECT_THROW(sight(broken), std::invalid_argument);
  broken = points;
  broken[4].camera_covariance << 1, 2, 2, 1;
  EXPECT_THROW(sight(broken), std::invalid_argument);
  SightPlaneOptions options;
  options.min_share = 0.4;
  EXPECT_THROW(sight(points, options), std::invalid_argument);
}

}  // namespace
}  // namespace procam::track
