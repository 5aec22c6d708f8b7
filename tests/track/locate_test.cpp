// The solve alone, on edges without images.
#include "procam/track/locate.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>

#include "marker_sightings.hpp"

namespace procam::track {
namespace {

using test::looking_at_room;
using test::room_map;
using test::sightings;
using test::wall_camera;

double distance(const Pose& a, const Pose& b) {
  return se3_log(a * b.inverse()).norm();
}

template <typename Call>
Error error_of(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "no error";
  return Error(ErrorKind::kInput, "", "", "");
}

TEST(Locate, FindsTheExactPoseFromExactEdges) {
  const Camera camera = wall_camera();
  const Pose truth = looking_at_room();
  MarkerMap one = room_map();
  one.markers.resize(1);
  for (const MarkerMap& map : {room_map(), one}) {
    const LocateResult result = locate(sightings(camera, truth, map, 0, 1), camera, map);
    EXPECT_LT(distance(result.camera_from_world, truth), 1e-6);
    EXPECT_EQ(result.markers.size(), map.markers.size());
    EXPECT_TRUE(result.diagnostics.items.empty());
  }
}

TEST(Locate, EdgesMovedTowardsWhiteMoveNothing) {
  const Camera camera = wall_camera();
  MarkerMap map = room_map();
  map.markers.resize(1);
  MarkerDetections detections = sightings(camera, looking_at_room(), map, 0, 1);
  for (SeenMarker& marker : detections.markers)
    for (MarkerEdge& edge : marker.edges) {
      // 0.25 px along the print's directions, as ink that spreads would.
      const Vec2 unit = edge.on_marker + 1e-3 * edge.towards_white;
      const Vec2 ahead =
          *camera.project(looking_at_room() * Vec3(unit.x() * 0.16, unit.y() * 0.16, 0)) - edge.pixel;
      edge.pixel += 0.25 * ahead.normalized();
    }
  const LocateResult result = locate(detections, camera, map);
  const double without_it = 0.25 / 40;  // half the marker is 54 px: its distance would be off by this share
  EXPECT_LT(std::abs(result.camera_from_world.translation.z() / looking_at_room().translation.z() - 1),
            0.1 * without_it);
}

TEST(Locate, CovarianceIsThatOfTheSpread) {
  const Camera camera = wall_camera();
  const Pose truth = looking_at_room();
  MarkerMap one = room_map();
  one.markers.resize(1);
  // 100 solves, 6 numbers each: chi-square with 600 degrees of freedom, sigma 34.6. Bounds at 4 sigma: false
  // alarm 6e-5 for each of the two maps.
  for (const MarkerMap& map : {room_map(), one}) {
    double chi2 = 0;
    for (int seed = 0; seed < 100; ++seed) {
      const LocateResult result =
          locate(sightings(camera, truth, map, 0.05, std::uint64_t(seed)), camera, map);
      const Vec6 xi = se3_log(truth * result.camera_from_world.inverse());
      // The enlargement by the residuals is never below one, which alone makes the stated sigmas a little
      // large; it is taken back here.
      chi2 += xi.dot(result.covariance.ldlt().solve(xi)) * std::max(1.0, result.chi2_per_dof);
    }
    EXPECT_NEAR(chi2, 600, 139);
  }
}

TEST(Locate, CovarianceCountsTheMapsSigmas) {
  const Camera camera = wall_camera();
  const Pose truth = looking_at_room();
  MarkerMap map = room_map();
  map.position_sigma = 0.002;
  map.angle_sigma = 0.004;
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  double chi2 = 0;
  for (int seed = 0; seed < 40; ++seed) {
    MarkerMap hung = map;
    for (PlacedMarker& placed : hung.markers) {
      Vec6 zeta;
      for (int i = 0; i < 6; ++i) zeta[i] = normal(random) * (i < 3 ? map.angle_sigma : map.position_sigma);
      placed.world_from_marker = placed.world_from_marker * se3_exp(zeta);
    }
    const LocateResult result =
        locate(sightings(camera, truth, hung, 0.03, std::uint64_t(seed)), camera, map);
    const Vec6 xi = se3_log(truth * result.camera_from_world.inverse());
    chi2 += xi.dot(result.covariance.ldlt().solve(xi)) * std::max(1.0, result.chi2_per_dof);
  }
  EXPECT_NEAR(chi2, 240, 88);  // 240 degrees of freedom, sigma 21.9, 4 sigma as above
}

TEST(Locate, NamesTheMarkerThatWasMoved) {
  const Camera camera = wall_camera();
  MarkerMap hung = room_map();
  hung.markers[2].world_from_marker.translation.x() += 0.02;
  const LocateResult result = locate(sightings(camera, looking_at_room(), hung, 0.03, 5), camera, room_map());
  EXPECT_LT(distance(result.camera_from_world, looking_at_room()), 2e-3);
  const Diagnostic* remark = result.diagnostics.find("marker_left_out");
  ASSERT_NE(remark, nullptr);
  EXPECT_NE(remark->message.find("marker 11"), std::string::npos) << remark->message;
  for (const LocatedMarker& marker : result.markers) EXPECT_EQ(marker.used, marker.id != 11) << marker.id;
}

TEST(Locate, TwoMarkersThatDisagreeAreNoMajority) {
  const Camera camera = wall_camera();
  MarkerMap map = room_map();
  map.markers.resize(2);
  MarkerMap hung = map;
  hung.markers[1].world_from_marker.translation.y() += 0.05;
  const Error error =
      error_of([&] { locate(sightings(camera, looking_at_room(), hung, 0.03, 6), camera, map); });
  EXPECT_EQ(error.kind(), ErrorKind::kDegenerate);
  EXPECT_NE(std::string(error.what()).find("3, 7"), std::string::npos) << error.what();
}

/// A small marker, far off and nearly straight on: its tilt could have either sign.
MarkerMap small_marker() {
  MarkerMap map;
  map.dictionary = MarkerDictionary::k4x4_50;
  map.markers = {{5, 0.05, Pose()}};
  return map;
}
const Pose kFarOff(so3_exp(Vec3(0.25, -0.2, 0.3)), Vec3(0.1, 0.05, 3));

TEST(Locate, RefusesAPoseThatTheOtherTiltExplainsAsWell) {
  const Camera camera = wall_camera();
  const Error error =
      error_of([&] { locate(sightings(camera, kFarOff, small_marker(), 0.25, 2), camera, small_marker()); });
  EXPECT_EQ(error.kind(), ErrorKind::kDegenerate);
  EXPECT_NE(error.why().find("second pose"), std::string::npos) << error.what();
}

TEST(Locate, AdviceFitsTheView) {
  const Camera camera = wall_camera();
  const auto advice = [&](const Pose& pose, bool coarse) {
    MarkerDetections seen = sightings(camera, pose, small_marker(), 0.3, 2);
    for (SeenMarker& marker : seen.markers) {
      marker.covariance = 0.09 * Eigen::Matrix<double, 8, 8>::Identity();
      marker.edges.clear();
      marker.coarse = coarse;
    }
    return error_of([&] { locate(seen, camera, small_marker()); }).next();
  };
  EXPECT_NE(advice(kFarOff, true).find("marker_coarse"), std::string::npos);
  const Pose straight_on(so3_exp(Vec3(0.17, -0.15, 0.3)), Vec3(0.1, 0.05, 3));
  EXPECT_NE(advice(straight_on, false).find("from the side"), std::string::npos)
      << advice(straight_on, false);
  const Pose from_the_side(so3_exp(Vec3(0.5, -0.5, 0.3)), Vec3(0.1, 0.05, 3));
  EXPECT_NE(advice(from_the_side, false).find("print the marker larger"), std::string::npos)
      << advice(from_the_side, false);
}

TEST(Locate, TakesTheRightTiltWhereTheImageIsGoodEnough) {
  const Camera camera = wall_camera();
  // 40 seeds: the odds that a wrong tilt gets less than the allowed share are far below 1e-6 at this noise.
  for (int seed = 0; seed < 40; ++seed) {
    const LocateResult result =
        locate(sightings(camera, kFarOff, small_marker(), 0.01, std::uint64_t(seed)), camera, small_marker());
    EXPECT_LT(se3_log(result.camera_from_world * kFarOff.inverse()).head<3>().norm(), 0.1);
    EXPECT_TRUE(result.other.has_value());
    EXPECT_LT(result.other_odds, 0.05);
  }
}

TEST(Locate, SaysThatNoneOfTheGivenMarkersIsSeen) {
  const Camera camera = wall_camera();
  const Error error = error_of(
      [&] { locate(sightings(camera, looking_at_room(), room_map(), 0, 1), camera, small_marker()); });
  EXPECT_EQ(error.kind(), ErrorKind::kNotEnoughData);
  EXPECT_NE(error.why().find("3, 7, 11, 20"), std::string::npos) << error.what();
}

/// A rig with a covariance that names lens and places, correlated.
Rig uncertain_rig() {
  Rig rig;
  rig.cameras.push_back({"camera", wall_camera(), Pose()});
  Camera inverse{{1024, 768}, {1880.0, 1891.0, 498.0, 846.0, 0.0}, NoDistortion{}};
  rig.projectors.push_back(
      {"projector", {inverse}, Pose(so3_exp(Vec3(0.07, -0.11, 0.02)), Vec3(0.19, -0.31, -0.08)).inverse()});
  rig.covariance.names = {"camera.fx", "camera.fy", "camera.cx", "camera.cy", "camera.k1"};
  for (const std::string& name : pose_increment_names("rig_from_projector"))
    rig.covariance.names.push_back(name);
  VecX sigma(11);
  sigma << 2, 2, 3, 3, 2e-3, 1e-3, 1e-3, 1e-3, 1e-3, 2e-3, 3e-3;
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal;
  MatX root = MatX::NullaryExpr(11, 11, [&] { return normal(random); });
  MatX correlated = root * root.transpose() / 11 + MatX::Identity(11, 11);
  rig.covariance.matrix = sigma.asDiagonal() * correlated * sigma.asDiagonal();
  return rig;
}

/// The same pixels through intrinsics that are not theirs: an image rotated by 180 degrees, and a digital zoom.
TEST(Locate, ImagesOfAnotherCameraFailTheCheck) {
  const Camera camera = wall_camera();
  const MarkerMap map = room_map();
  const MarkerDetections seen = sightings(camera, looking_at_room(), map, 0.03, 4);
  EXPECT_EQ(locate(seen, camera, map).diagnostics.find("map_disagrees"), nullptr);
  // A camera of which the image is the rotated, or the zoomed one of `camera`.
  Camera rotated = camera, zoomed = camera;
  rotated.intrinsics.cx = camera.size.width - 1 - camera.intrinsics.cx;
  rotated.intrinsics.cy = camera.size.height - 1 - camera.intrinsics.cy;
  zoomed.intrinsics.fx *= 0.9;
  zoomed.intrinsics.fy *= 0.9;
  for (const Camera& other : {rotated, zoomed}) {
    const LocateResult result = locate(seen, other, map);
    const Diagnostic* found = result.diagnostics.find("map_disagrees");
    ASSERT_TRUE(found) << result.chi2_per_dof;
    EXPECT_TRUE(result.diagnostics.failed()) << found->message;
    EXPECT_NE(found->message.find("rotated, cropped or zoomed"), std::string::npos);
    EXPECT_GT(distance(result.camera_from_world, looking_at_room()), 0.01);
  }
  // Slightly off remains a warning.
  Camera shifted = camera;
  shifted.intrinsics.cx -= 9;
  const LocateResult slightly = locate(seen, shifted, map);
  EXPECT_TRUE(slightly.diagnostics.find("map_disagrees")) << slightly.chi2_per_dof;
  EXPECT_FALSE(slightly.diagnostics.failed()) << slightly.chi2_per_dof;
}

TEST(ProjectorChain, CovarianceIsThatOfMovingEveryParameterOfTheRig) {
  const Rig rig = uncertain_rig();
  const MarkerMap map = room_map();
  const MarkerDetections detections = sightings(rig.camera().camera, looking_at_room(), map, 0, 1);
  const auto total = [&](const Rig& other) {
    const LocateResult seen = locate(detections, other.camera().camera, map);
    return projector_chain(other, other.projector(), other.camera(), seen);
  };
  const Chain chain = total(rig);
  ASSERT_EQ(chain.links.size(), 2u);
  EXPECT_LT(distance(chain.total.target_from_source.pose, rig.projector_from_camera() * looking_at_room()),
            1e-6);

  // The same by differences: every parameter moved, the image located again.
  const std::vector<std::string> lens = parameter_names(rig.camera().camera);
  MatX by(6, 11);
  for (Eigen::Index i = 0; i < 11; ++i) {
    const double step = 0.05 * std::sqrt(rig.covariance.matrix(i, i));
    Vec6 moved[2];
    for (const int side : {0, 1}) {
      Rig other = rig;
      const double change = side == 0 ? -step : step;
      if (i < 5) {
        VecX p = parameters_of(rig.camera().camera);
        const std::string name = rig.covariance.names[std::size_t(i)].substr(7);
        p[std::find(lens.begin(), lens.end(), name) - lens.begin()] += change;
        other.cameras[0].camera = with_parameters(rig.camera().camera, p);
      } else {
        other.projectors[0].rig_from_projector =
            se3_exp(Vec6(change * Vec6::Unit(i - 5))) * rig.projectors[0].rig_from_projector;
      }
      moved[side] =
          se3_log(total(other).total.target_from_source.pose * chain.total.target_from_source.pose.inverse());
    }
    by.col(i) = (moved[1] - moved[0]) / (2 * step);
  }
  const Mat6 expected = by * rig.covariance.matrix * by.transpose();
  const Mat6& covariance = chain.total.target_from_source.covariance;
  for (int i = 0; i < 6; ++i)
    for (int k = 0; k < 6; ++k)
      EXPECT_NEAR(covariance(i, k), expected(i, k), 0.02 * std::sqrt(expected(i, i) * expected(k, k)));
}

}  // namespace
}  // namespace procam::track
