/// A surface with markers on it, in the rig: the pose of one image, and the one that a hinge permits.
#include "procam/track/sight_surface.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "procam/detect/marker_edges.hpp"
#include "procam/simulate/marker_view.hpp"
#include "support/expect_error.hpp"
#include "support/lopsided.hpp"

namespace procam::track {
namespace {

RigCamera lopsided_camera() {
  RigCamera camera;
  camera.name = "eye";
  camera.camera.size = {640, 480};
  camera.camera.intrinsics = {720, 705, 331, 228, 1.1};
  camera.rig_from_camera = test::lopsided_pose();
  return camera;
}

MarkerMap marker_of(double size) {
  MarkerMap map;
  map.dictionary = MarkerDictionary::kAprilTag36h11;
  map.markers = {{3, size, Pose(so3_exp(Vec3(0, 0, 0.2)), Vec3(0.11, 0.07, 0))}};
  return map;
}

MarkerDetections seen_at(const RigCamera& camera, const MarkerMap& map, const Pose& camera_from_surface,
                         std::uint64_t seed) {
  const MarkerCells cells = detect::marker_cells(map.dictionary);
  simulate::MarkerViewOptions options;
  options.seed = seed;
  return detect::detect_marker_edges(
      simulate::marker_view(camera.camera, camera_from_surface, map.markers, cells, options), cells,
      {camera.camera});
}

TEST(SightSurface, PlacesItInTheRig) {
  const RigCamera camera = lopsided_camera();
  const MarkerMap map = marker_of(0.2);
  for (int i = 0; i < 3; ++i) {
    const Pose camera_from_surface(so3_exp(Vec3(0.4, -0.5 + 0.1 * i, 0.1)), Vec3(0.05 * i, -0.03, 1.3));
    const SurfaceSighting seen =
        sight_surface(seen_at(camera, map, camera_from_surface, std::uint64_t(i)), camera, map);
    const Pose truth = camera.rig_from_camera * camera_from_surface;
    ASSERT_EQ(seen.poses.size(), 1u);
    const PoseWithCovariance& found = seen.poses[0].pose;
    const Vec6 off = se3_log(Pose(truth * found.pose.inverse()));
    // Chi-square of 6: below 30 but for 1 pose of 25 000; three are looked at, with fixed seeds.
    EXPECT_LT(off.dot(found.covariance.ldlt().solve(off)), 30) << i;
    EXPECT_LT((found.pose.translation - truth.translation).norm(), 0.01);
    EXPECT_EQ(seen.markers, 1);
    const Vec2 middle =
        *camera.camera.project(camera_from_surface * map.markers[0].world_from_marker.translation);
    EXPECT_NEAR(seen.row, middle.y(), 3);
  }
}

/// The corners of a marker alone, exact, with this standard deviation.
MarkerDetections corners_at(const RigCamera& camera, const MarkerMap& map, const Pose& camera_from_surface,
                            double sigma_px) {
  SeenMarker marker;
  marker.id = map.markers[0].id;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec2 on_marker = marker_corners()[i] * map.markers[0].size;
    marker.corners[i] = *camera.camera.project(camera_from_surface * map.markers[0].world_from_marker *
                                               Vec3(on_marker.x(), on_marker.y(), 0));
  }
  marker.covariance = sigma_px * sigma_px * Eigen::Matrix<double, 8, 8>::Identity();
  return {camera.camera.size, {marker}, {}};
}

/// A small marker far away has two poses, each with its covariance.
TEST(SightSurface, BothPosesThatFitAreGiven) {
  const RigCamera camera = lopsided_camera();
  const MarkerMap map = marker_of(0.08);
  const Pose camera_from_surface(so3_exp(Vec3(0.03, 0.3, 0.1)), Vec3(0.05, -0.03, 2.6));
  const Pose truth = camera.rig_from_camera * camera_from_surface;
  EXPECT_EQ(sight_surface(corners_at(camera, map, camera_from_surface, 0.01), camera, map).poses.size(), 1u);
  const SurfaceSighting seen = sight_surface(corners_at(camera, map, camera_from_surface, 0.3), camera, map);
  ASSERT_EQ(seen.poses.size(), 2u);
  EXPECT_EQ(seen.poses[0].chi2, 0);
  EXPECT_GT(seen.poses[1].chi2, 0);
  EXPECT_LT(seen.poses[1].chi2, 2 * std::log(19)) << "odds of 5 %";
  EXPECT_LT(seen.poses[0].pose.pose.rotation.angularDistance(truth.rotation), 0.01);
  const Pose& other = seen.poses[1].pose.pose;
  EXPECT_GT(other.rotation.angularDistance(truth.rotation), 0.3);
  // As well known as the first, where it is.
  const double ratio =
      seen.poses[1].pose.covariance.determinant() / seen.poses[0].pose.covariance.determinant();
  EXPECT_GT(ratio, 0.01);
  EXPECT_LT(ratio, 100);
  // What was seen before decides.
  PoseChooser chooser;
  const Pose before = truth * Pose(so3_exp(Vec3(0.002, -0.003, 0.001)), Vec3(0.003, 0.002, 0.001));
  chooser.choose(10, {{{before, seen.poses[0].pose.covariance}, 0}});
  EXPECT_LT(chooser.choose(10.03, seen.poses).odds, 0.01);
  PoseChooser mirrored;
  mirrored.choose(10, {{{other, seen.poses[1].pose.covariance}, 0}});
  EXPECT_EQ(mirrored.choose(10.03, seen.poses).index, 1u);
}

TEST(SightSurface, AFitThatMissesTheEdgesIsRefused) {
  const RigCamera camera = lopsided_camera();
  MarkerMap map = marker_of(0.2);
  MarkerDetections seen = seen_at(camera, map, Pose(so3_exp(Vec3(0.4, -0.5, 0.1)), Vec3(0, -0.03, 1.3)), 1);
  for (MarkerEdge& edge : seen.markers[0].edges)
    edge.pixel += 2 * Vec2(std::sin(40 * edge.pixel.x()), std::cos(40 * edge.pixel.y()));
  EXPECT_ERROR(sight_surface(seen, camera, map), kDegenerate, "standard deviations");
  MarkerDetections nothing;
  nothing.image_size = camera.camera.size;
  EXPECT_ERROR(sight_surface(nothing, camera, map), kNotEnoughData, "no marker");
}

Hinge lopsided_hinge() {
  Hinge hinge;
  hinge.rig_from_closed = Pose(so3_exp(Vec3(0.1, 0.4, -0.2)), Vec3(0.3, -0.4, 2.1));
  hinge.point = Vec3(0.02, 0.3, 0.01);
  hinge.direction = Vec3(0.05, 0.99, -0.03).normalized();
  return hinge;
}

Pose opened(const Hinge& hinge, double angle) {
  return hinge.rig_from_closed * Pose(Eigen::Quaterniond::Identity(), hinge.point) *
         Pose(so3_exp(Vec3(angle * hinge.direction)), Vec3::Zero()) *
         Pose(Eigen::Quaterniond::Identity(), -hinge.point);
}

TEST(Hinge, FindsTheAngleAndItsVariance) {
  const Hinge hinge = lopsided_hinge();
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  Vec6 sigma;
  sigma << 0.02, 0.03, 0.005, 0.002, 0.003, 0.008;
  double chi2_of_angle = 0, chi2 = 0;
  constexpr int kDraws = 400;
  for (int i = 0; i < kDraws; ++i) {
    const double angle = -1.4 + 2.8 * i / kDraws;
    const Pose truth = opened(hinge, angle);
    const HingedPose exact = on_hinge({truth, Mat6(sigma.cwiseAbs2().asDiagonal())}, hinge);
    EXPECT_NEAR(exact.angle, angle, 1e-9);
    EXPECT_LT(se3_log(Pose(truth.inverse() * exact.rig_from_surface.pose)).norm(), 1e-9);
    // What is seen has the noise of the image, in the rig's frame, and that of the axis, in the surface's.
    Vec6 image, axis;
    for (Eigen::Index k = 0; k < 6; ++k) image[k] = sigma[k] * normal(random), axis[k] = normal(random);
    axis.head<3>() *= hinge.angle_sigma, axis.tail<3>() *= hinge.position_sigma;
    const HingedPose seen =
        on_hinge({se3_exp(image) * truth * se3_exp(axis), Mat6(sigma.cwiseAbs2().asDiagonal())}, hinge);
    const Vec6 off = se3_log(Pose(truth * seen.rig_from_surface.pose.inverse()));
    chi2_of_angle += std::pow(seen.angle - angle, 2);
    chi2 += seen.chi2;
    EXPECT_LT(off.dot(seen.rig_from_surface.covariance.ldlt().solve(off)), 30);
  }
  // The mean of 400 chi-squares of 5 is within 4 standard deviations of 5: 1 false alarm in 16 000, seed fixed.
  EXPECT_NEAR(chi2 / kDraws, 5, 4 * std::sqrt(10.0 / kDraws));
  EXPECT_LT(std::sqrt(chi2_of_angle / kDraws), 0.01);  // of 0.03 without the hinge
}

TEST(Hinge, AnotherAxisShows) {
  const Hinge hinge = lopsided_hinge();
  Hinge wrong = hinge;
  wrong.point.x() += 0.4;  // the other edge of the door
  const Mat6 covariance = 1e-6 * Mat6::Identity();
  EXPECT_LT(on_hinge({opened(hinge, 0.7), covariance}, hinge).chi2, 1e-6);
  EXPECT_GT(on_hinge({opened(hinge, 0.7), covariance}, wrong).chi2, 100);
  Hinge skewed = hinge;
  skewed.direction *= 2;
  EXPECT_THROW(on_hinge({Pose(), covariance}, skewed), std::invalid_argument);
}

}  // namespace
}  // namespace procam::track
