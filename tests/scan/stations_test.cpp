#include "procam/scan/stations.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "procam/core/base/stats.hpp"
#include "procam/scan/merge.hpp"
#include "support/expect_error.hpp"
#include "true_room.hpp"

namespace procam::scan::test {
namespace {

int times_in(const std::string& text, const std::string& part) {
  int count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

RegistrationOptions near_search() {
  RegistrationOptions options;
  options.max_turn = 24 * kDegree;
  options.max_move = 0.5;
  return options;
}

/// The error of the points by the modes against points that another rig measures in the same light.
TEST(RigModes, AreTheMotionOfThePointsWithTheRig) {
  std::mt19937 random(3);
  const Rig truth = true_rig(), off = calibrated_rig(truth, random);
  const SeenRoom seen = look(truth, alcove(), Pose(), 1e-6, random);
  LightMap light = seen.light;
  for (int y = 0; y < light.sigma.height(); ++y)
    for (int x = 0; x < light.sigma.width(); ++x)
      for (int c = 0; c < 2; ++c)
        if (light.sigma.at(x, y, c) > 0) light.sigma.at(x, y, c) = 0.05f;
  ScanOptions options;
  options.consistency_sigmas = 1e6;
  const Scan right = measure_depth(light, truth, "", "", options),
             wrong = measure_depth(light, off, "", "", options);
  const RigModes& modes = wrong.rig_modes;
  ASSERT_EQ(modes.count(), 14);
  EXPECT_LT((modes.root * modes.root.transpose() - truth.covariance.matrix).norm(),
            1e-9 * truth.covariance.matrix.norm());
  VecX change(14);
  change.head<4>() = (parameters_of(off.camera().camera) - parameters_of(truth.camera().camera)).head<4>();
  change.segment<4>(4) = (parameters_of(off.projector().projector.inverse_camera) -
                          parameters_of(truth.projector().projector.inverse_camera))
                             .head<4>();
  change.tail<6>() =
      se3_log(off.projector().rig_from_projector * truth.projector().rig_from_projector.inverse());
  const VecX c = modes.root.fullPivLu().solve(change);
  const ImageF rays = pixel_rays(off.camera().camera), true_rays = pixel_rays(truth.camera().camera);
  const std::size_t stride = 1 + 4 * 14;
  int compared = 0;
  double largest = 0, moved = 0;
  for (int row = 0; row < modes.rows; ++row)
    for (int column = 0; column < modes.columns; ++column) {
      const float* node =
          &modes.nodes[(std::size_t(row) * std::size_t(modes.columns) + std::size_t(column)) * stride];
      const int x = 16 * column + 8, y = 16 * row + 8;
      if (!(node[0] > 0) || x >= 320 || y >= 240 || !right.measured(x, y) || !wrong.measured(x, y)) continue;
      if (std::abs(node[0] - wrong.depth.at(x, y)) > 1e-6f) continue;  // the cell's pixel is another
      Vec3 expected = Vec3::Zero();
      for (Eigen::Index k = 0; k < 14; ++k)
        expected += c[k] * Vec3(node[1 + 4 * k], node[2 + 4 * k], node[3 + 4 * k]);
      const auto point = [&](const Scan& scan, const ImageF& its_rays, const Rig& rig) {
        return Vec3(rig.camera().rig_from_camera *
                    Vec3(double(scan.depth.at(x, y)) * Vec3(its_rays.at(x, y, 0), its_rays.at(x, y, 1), 1)));
      };
      const Vec3 off_by = point(wrong, rays, off) - point(right, true_rays, truth);
      largest = std::max(largest, (off_by - expected).norm());
      moved = std::max(moved, off_by.norm());
      ++compared;
    }
  EXPECT_GT(compared, 100);
  EXPECT_GT(moved, 1e-4);
  EXPECT_LT(largest, 0.05 * moved);
}

/// Six elements of two poses: each beyond four sigmas in one of 1300 seeds.
TEST(Stations, AreRegisteredByTheirSurfacesAlone) {
  std::mt19937 random(5);
  const Rig truth = true_rig(), rig = calibrated_rig(truth, random);
  const SeenStations seen = see(alcove(), truth, rig, 3, random);
  const Registration at = register_stations(seen.stations, near_search());
  EXPECT_EQ(at.pairs.size(), 3u);
  EXPECT_EQ(at.stations[0].pose.covariance, Mat6::Zero());
  for (int s = 1; s < 3; ++s) {
    const Vec6 error = pose_error(at, s);
    const PoseWithCovariance& pose = at.stations[std::size_t(s)].pose;
    const double far =
        (pose.pose.translation - (true_station(0).inverse() * true_station(s)).translation).norm();
    EXPECT_LT(far, 3e-3);
    EXPECT_LT(error.head<3>().norm(), 0.1 * kDegree);
    for (int i = 0; i < 6; ++i)
      EXPECT_LT(std::abs(error[i]), 4 * std::sqrt(pose.covariance(i, i)))
          << "station " << s << " element " << i;
    // Not by stating too much: sub-millimetre scans of a metre state less than a millimetre.
    EXPECT_LT(std::sqrt(point_covariance(pose, Vec3::Zero()).trace()), 3e-3);
  }
}

TEST(Stations, RefinesKnownPoses) {
  std::mt19937 random(7);
  const Rig truth = true_rig(), rig = calibrated_rig(truth, random);
  SeenStations seen = see(alcove(), truth, rig, 3, random);
  know_poses(0.02, 0.6 * kDegree, random, seen.stations);
  const Registration at = register_stations(seen.stations);
  EXPECT_TRUE(at.has_known_poses);
  EXPECT_EQ(at.diagnostics.find("poses_disagree"), nullptr);
  // Relative to the first: the surfaces know it far better than the poses.
  for (int s = 1; s < 3; ++s) {
    const Pose estimated = at.stations[0].pose.pose.inverse() * at.stations[std::size_t(s)].pose.pose;
    const Pose right = true_station(0).inverse() * true_station(s);
    EXPECT_LT((estimated.translation - right.translation).norm(), 2e-3);
    const Eigen::Quaterniond turn(estimated.rotation * right.rotation.conjugate());
    EXPECT_LT(so3_log(turn).norm(), 0.1 * kDegree);
  }
  for (int s = 0; s < 3; ++s) {
    const Vec6 error = pose_error(at, s);
    const Mat6& covariance = at.stations[std::size_t(s)].pose.covariance;
    for (int i = 0; i < 6; ++i)
      EXPECT_LT(std::abs(error[i]), 4 * std::sqrt(covariance(i, i))) << s << " " << i;
    // In the world three poses are known better than one.
    const Mat6& before = seen.stations[std::size_t(s)].world_from_rig->covariance;
    EXPECT_LT(covariance.diagonal().head<3>().sum(), 0.6 * before.diagonal().head<3>().sum());
  }
}

TEST(Stations, WarnsOfAKnownPoseThatTheSurfacesContradict) {
  std::mt19937 random(8);
  const Rig truth = true_rig();
  SeenStations seen = see(alcove(), truth, truth, 2, random);
  know_poses(1e-3, 0.05 * kDegree, random, seen.stations);
  Vec6 bump = Vec6::Zero();
  bump[3] = bump[5] = 0.015;
  seen.stations[1].world_from_rig->pose = se3_exp(bump) * seen.stations[1].world_from_rig->pose;
  EXPECT_NE(register_stations(seen.stations).diagnostics.find("poses_disagree"), nullptr);
  RegistrationOptions keep;
  keep.refine = false;
  const Registration kept = register_stations(seen.stations, keep);
  EXPECT_NE(kept.diagnostics.find("poses_disagree"), nullptr);
  EXPECT_EQ(kept.stations[1].pose.pose.translation, seen.stations[1].world_from_rig->pose.translation);
}

TEST(Stations, NamesTheDirectionsThatAPlaneLeavesOpen) {
  std::mt19937 random(9);
  const Rig truth = true_rig(), rig = calibrated_rig(truth, random);
  const Vec3 normal = (true_station(0).inverse().rotate(Vec3(0.1, 0.03, 1))).normalized();
  const SeenStations seen = see({plane(Vec3(0.1, 0.03, 1), 2.0)}, truth, rig, 2, random);
  const Error error = procam::test::error_of([&] { register_stations(seen.stations, near_search()); });
  EXPECT_EQ(error.kind(), ErrorKind::kDegenerate) << error.what();
  EXPECT_EQ(times_in(error.why(), "position along"), 2) << error.why();
  EXPECT_EQ(times_in(error.why(), "rotation about the axis"), 1) << error.why();
  const std::string after = error.why().substr(error.why().find("axis (") + 6);
  Vec3 axis;
  ASSERT_EQ(std::sscanf(after.c_str(), "%lf %lf %lf", &axis.x(), &axis.y(), &axis.z()), 3) << after;
  EXPECT_GT(axis.normalized().dot(normal), std::cos(3 * kDegree)) << error.why();
}

TEST(Stations, NamesTheDirectionsThatACorridorLeavesOpen) {
  std::mt19937 random(10);
  const Rig truth = true_rig();
  const Surfaces corridor = {plane(Vec3(1, 0, 0), 0.4), plane(Vec3(-1, 0, 0), 0.5)};
  const Error of_corridor = procam::test::error_of(
      [&] { register_stations(see(corridor, truth, truth, 2, random).stations, near_search()); });
  EXPECT_EQ(of_corridor.kind(), ErrorKind::kDegenerate) << of_corridor.what();
  EXPECT_EQ(times_in(of_corridor.why(), "position along"), 2) << of_corridor.why();
  EXPECT_EQ(times_in(of_corridor.why(), "rotation about the axis"), 1) << of_corridor.why();
}

TEST(Stations, NamesTheDirectionsThatABallLeavesOpen) {
  std::mt19937 random(10);
  const Rig truth = true_rig();
  const Error of_ball = procam::test::error_of([&] {
    register_stations(see({ball(Vec3(0.05, 0.02, 1.7), 0.5)}, truth, truth, 2, random).stations,
                      near_search());
  });
  EXPECT_EQ(of_ball.kind(), ErrorKind::kDegenerate) << of_ball.what();
  EXPECT_EQ(times_in(of_ball.why(), "rotation about the axis"), 3) << of_ball.why();
  EXPECT_EQ(times_in(of_ball.why(), "position along"), 0) << of_ball.why();
}

TEST(Stations, KnownPosesFixWhatAPlaneLeavesOpen) {
  std::mt19937 random(11);
  const Rig truth = true_rig();
  SeenStations seen = see({plane(Vec3(0, 0, 1), 2.0)}, truth, truth, 2, random);
  know_poses(0.01, 0.4 * kDegree, random, seen.stations);
  const Registration at = register_stations(seen.stations);
  EXPECT_NE(at.diagnostics.find("unobservable"), nullptr);
  EXPECT_EQ(at.stations[1].unobservable.size(), 3u);
  // In the wall's plane as the poses are known. Across, two stations share their knowledge.
  const Mat3 before = point_covariance(*seen.stations[1].world_from_rig, Vec3::Zero()),
             after = point_covariance(at.stations[1].pose, Vec3::Zero());
  EXPECT_NEAR(std::sqrt(after(0, 0) / before(0, 0)), 1, 0.05);
  EXPECT_LT(std::sqrt(after(2, 2) / before(2, 2)), 0.85);
  const Vec6 moved = se3_log(at.stations[1].pose.pose * seen.stations[1].world_from_rig->pose.inverse());
  EXPECT_LT(std::abs(moved[2]), 0.05 * 0.4 * kDegree) << "rotation about the normal";
}

TEST(Stations, RefusesTooLittleOverlap) {
  std::mt19937 random(12);
  const Rig truth = true_rig();
  SeenStations seen = see(alcove(), truth, truth, 2, random);
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) {
      if (x > 110) seen.stations[0].scans[0].depth.at(x, y) = 0;
      if (x < 230) seen.stations[1].scans[0].depth.at(x, y) = 0;
    }
  const ErrorKind kind =
      procam::test::error_of([&] { register_stations(seen.stations, near_search()); }).kind();
  EXPECT_TRUE(kind == ErrorKind::kNotEnoughData || kind == ErrorKind::kDegenerate);
}

TEST(Stations, RefusesWhatCannotBe) {
  std::mt19937 random(13);
  const Rig truth = true_rig();
  SeenStations seen = see(alcove(), truth, truth, 2, random);
  std::vector<Station> stations = seen.stations;
  EXPECT_THROW(register_stations({stations[0]}), std::invalid_argument);
  RegistrationOptions keep;
  keep.refine = false;
  EXPECT_THROW(register_stations(stations, keep), std::invalid_argument);
  stations[0].world_from_rig = PoseWithCovariance{true_station(0), Mat6::Identity()};
  EXPECT_THROW(register_stations(stations), std::invalid_argument);
  stations[1].world_from_rig = PoseWithCovariance{true_station(1), Mat6::Zero()};
  EXPECT_THROW(register_stations(stations), std::invalid_argument);
}

TEST(MergedStations, AreOneSurfaceBetterThanOneStation) {
  std::mt19937 random(14);
  const Rig truth = true_rig(), rig = calibrated_rig(truth, random);
  SeenStations seen = see(alcove(), truth, rig, 3, random);
  know_poses(0.002, 0.05 * kDegree, random, seen.stations);
  const Registration at = register_stations(seen.stations);
  const MergedStations merged = merge_stations(seen.stations, at);
  EXPECT_FALSE(fault_of(merged.mesh));
  EXPECT_EQ(merged.diagnostics.find("contradictions"), nullptr);
  EXPECT_GT(merged.fused_share, 0.5);
  int single = 0;
  for (const Station& station : seen.stations) single += station.scans[0].counts.measured;
  EXPECT_LT(int(merged.cloud.points.size()), 0.8 * single) << "each part once";
  EXPECT_GT(int(merged.cloud.points.size()), 0.35 * single);
  const ScanError error = compare(merged.cloud, seen.truth);
  EXPECT_GT(error.inside_3_sigma, 0.95);
  EXPECT_LT(error.outliers, 2e-3);
  // The same with each station by itself.
  std::vector<double> alone;
  for (std::size_t s = 0; s < 3; ++s)
    alone.push_back(compare(seen.stations[s].scans[0], seen.truth[s].depth.view()).rms);
  std::printf("merged %.3f mm (%.3f expected), stations %.3f %.3f %.3f mm, gap %.3f (%.3f)\n",
              1e3 * error.rms, 1e3 * error.expected_rms, 1e3 * alone[0], 1e3 * alone[1], 1e3 * alone[2],
              1e3 * merged.gap_before, 1e3 * merged.gap_expected);
  EXPECT_LT(merged.gap_before, 1.3 * merged.gap_expected);
  for (const Vec2& uv : merged.mesh.uv) ASSERT_TRUE(uv.minCoeff() >= 0 && uv.maxCoeff() <= 1);
}

TEST(MergedStations, ReportsWhatWasMovedBetweenTheStations) {
  std::mt19937 random(15);
  const Rig truth = true_rig();
  SeenStations seen = see(alcove(), truth, truth, 1, random);
  Surfaces without = alcove();
  without.pop_back();
  seen.stations.push_back(see(without, truth, truth, 2, random).stations[1]);
  know_poses(1e-3, 0.02 * kDegree, random, seen.stations);
  const MergedStations merged = merge_stations(seen.stations, register_stations(seen.stations));
  EXPECT_NE(merged.diagnostics.find("contradictions"), nullptr);
}

TEST(ScanError, OfPointsInTheWorldIsAlongTheTrueNormal) {
  std::mt19937 random(16);
  const Rig truth = true_rig();
  const Vec3 normal = Vec3(0.3, -0.2, 1).normalized();
  const SeenRoom seen = look(truth, {plane(normal, 1.8)}, true_station(1), 1e-6, random);
  PointCloud cloud;
  for (int i = 0; i < 50; ++i) {
    const Vec3 ray = *truth.camera().camera.unproject(Vec2(100.3 + 2 * i, 80.4 + i));
    const Vec3 direction = seen.truth.world_from_camera.rotate(ray),
               from = seen.truth.world_from_camera.translation;
    const double t = (1.8 - normal.dot(from)) / normal.dot(direction);
    cloud.points.push_back(from + t * direction + 2e-3 * normal);
    cloud.sigma.push_back(i % 2 == 0 ? 1e-3 : 0.5e-3);
  }
  const ScanError error = compare(cloud, {seen.truth});
  EXPECT_EQ(error.compared, 50);
  EXPECT_NEAR(error.rms, 2e-3, 3e-5);
  EXPECT_NEAR(error.inside_3_sigma, 0.5, 1e-9);
}

/// Of many seeds: each element of the poses and the merged points, against what is stated. 300 numbers within three sigmas, of which
/// 99.7 % are expected.
TEST(StationsMonteCarlo, StatesTheErrorsThatManySeedsHave) {
  const Rig truth = true_rig();
  std::vector<double> in_sigmas, merged_rms, single_rms, position, angle, expected;
  double inside = 0, least_inside = 1;
  constexpr int kSeeds = 25;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    std::mt19937 random(1000 + seed);
    const Rig rig = calibrated_rig(truth, random);
    const SeenStations seen = see(alcove(), truth, rig, 3, random);
    const Registration at = register_stations(seen.stations, near_search());
    for (int s = 1; s < 3; ++s) {
      const Vec6 error = pose_error(at, s);
      const PoseWithCovariance& pose = at.stations[std::size_t(s)].pose;
      for (int i = 0; i < 6; ++i) in_sigmas.push_back(std::abs(error[i]) / std::sqrt(pose.covariance(i, i)));
      position.push_back(
          (pose.pose.translation - (true_station(0).inverse() * true_station(s)).translation).norm());
      angle.push_back(error.head<3>().norm());
    }
    std::vector<TrueView> views = seen.truth;
    for (TrueView& view : views) view.world_from_camera = true_station(0).inverse() * view.world_from_camera;
    const MergedStations merged = merge_stations(seen.stations, at);
    const ScanError error = compare(merged.cloud, views);
    merged_rms.push_back(error.rms);
    expected.push_back(error.expected_rms);
    for (std::size_t s = 0; s < 3; ++s) {
      PointCloud alone = point_cloud(seen.stations[s].scans[0]);
      for (Vec3& point : alone.points) point = true_station(int(s)) * point;
      single_rms.push_back(compare(alone, seen.truth).rms);
    }
    inside += error.inside_3_sigma / kSeeds;
    least_inside = std::min(least_inside, error.inside_3_sigma);
  }
  const auto share = [&](double limit) {
    return double(std::count_if(in_sigmas.begin(), in_sigmas.end(), [&](double s) { return s <= limit; })) /
           double(in_sigmas.size());
  };
  const auto rms = [](const std::vector<double>& values) {
    double sum = 0;
    for (const double v : values) sum += v * v / double(values.size());
    return std::sqrt(sum);
  };
  std::printf("poses: %.3f mm, %.4f deg RMS; within 1, 2, 3 sigma %.3f %.3f %.3f; RMS %.2f sigma\n",
              1e3 * rms(position), rms(angle) / kDegree, share(1), share(2), share(3), rms(in_sigmas));
  std::printf(
      "points: merged %.3f mm (%.3f expected), single stations %.3f mm; inside 3 sigma %.4f, at least %.4f\n",
      1e3 * rms(merged_rms), 1e3 * rms(expected), 1e3 * rms(single_rms), inside, least_inside);
  EXPECT_GT(share(3), 0.95);
  EXPECT_GT(share(1), 0.55);
  EXPECT_GT(rms(in_sigmas), 0.5) << "states too much";
  EXPECT_GT(inside, 0.95);
  EXPECT_LT(rms(merged_rms), rms(single_rms));
}

}  // namespace
}  // namespace procam::scan::test
