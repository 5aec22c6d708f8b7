#include "procam/track/pose_correction.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "procam/core/geometry/se3.hpp"

namespace procam::track {
namespace {

/// The rig looks along the base's x axis, and is not in its middle.
Pose base_from_rig() {
  Mat3 axes;
  axes.col(0) = -Vec3::UnitY(), axes.col(1) = -Vec3::UnitZ(), axes.col(2) = Vec3::UnitX();
  return Pose(Eigen::Quaterniond(axes) * so3_exp(Vec3(0.05, -0.1, 0.02)), Vec3(0.2, -0.07, 0.8));
}

/// A robot that drives and turns far from the world's origin.
Pose truth(double time) {
  return Pose(so3_exp(Vec3(0, 0, 0.7 + 0.3 * time)), Vec3(12 + 0.4 * time, -7 + 0.2 * time, 0));
}

/// The localiser's error: along x and y of the world, and about its z axis.
struct Off {
  double x = 0.021, y = -0.017, yaw = 0.012;
};
Pose localised(double time, const Off& off = {}) {
  const Pose pose = truth(time);
  return Pose(so3_exp(Vec3(0, 0, off.yaw)) * pose.rotation, pose.translation + Vec3(off.x, off.y, 0));
}

StampedPose message(double time, const Off& off = {}) {
  StampedPose result;
  result.arrival = time + 0.05;
  result.frame = "map", result.child = "base";
  result.frame_from_child = localised(time, off);
  return result;
}

PoseCorrectionOptions options() {
  PoseCorrectionOptions result;
  result.track.delay = 0.05;
  result.child_from_rig = base_from_rig();
  return result;
}

/// Of an image that determines these directions of rig_from_world to a millimetre or so, as drawn for the localiser's pose.
PoseSight sight(double time, const MatX& directions, const Off& off = {}) {
  PoseSight result;
  result.time = time;
  result.world_from_rig = localised(time, off) * base_from_rig();
  const Vec6 x = se3_log(Pose((truth(time) * base_from_rig()).inverse() * result.world_from_rig));
  result.information = 1e6 * directions * directions.transpose();
  result.score = result.information * x;
  return result;
}

/// Position along and across, and the angle, from the true pose.
Vec3 off_by(const StampedPose& pose) {
  const Pose wrong = pose.frame_from_child * truth(pose.arrival - 0.05).inverse();
  const Vec3 shift = pose.frame_from_child.translation - truth(pose.arrival - 0.05).translation;
  return {shift.x(), shift.y(), so3_log(wrong.rotation).z()};
}

void drive(PoseCorrection& correction, double from, double to) {
  for (double time = from; time < to; time += 0.1) correction.add(message(time));
}

TEST(PoseCorrection, AnImageThatSeesAllCorrectsAllAtItsExposure) {
  PoseCorrection correction(options());
  drive(correction, 10, 12);
  // Late: messages of later moments have come.
  const auto pose = correction.add(sight(11.63, MatX::Identity(6, 6)));
  ASSERT_TRUE(pose);
  EXPECT_NEAR(pose->arrival, 11.68, 1e-9);
  EXPECT_EQ(pose->frame, "map");
  EXPECT_EQ(pose->child, "base");
  EXPECT_FALSE(pose->stamp);
  EXPECT_LT(off_by(*pose).head<2>().norm(), 1e-3);
  EXPECT_NEAR(off_by(*pose).z(), 0, 3e-4);
  EXPECT_NEAR(correction.status().error[3], -0.021, 3e-3);  // relative to the filtered messages
  EXPECT_NEAR(correction.status().error[2], -0.012, 3e-4);
  EXPECT_LT(correction.status().sigma[3], 0.0015);
}

TEST(PoseCorrection, WhatOnePlaneDoesNotShowStaysTheLocalisers) {
  PoseCorrection correction(options());
  drive(correction, 10, 12);
  // A wall across the rig's z axis: its distance and two tilts.
  MatX plane = MatX::Zero(6, 3);
  plane(0, 0) = plane(1, 1) = plane(5, 2) = 1;
  const double time = 11.9;
  const auto pose = correction.add(sight(time, plane));
  ASSERT_TRUE(pose);
  const Pose world_from_rig = truth(time) * base_from_rig();
  const Vec3 ahead = world_from_rig.rotate(Vec3::UnitZ()),
             sideways = Vec3(-ahead.y(), ahead.x(), 0).normalized();
  const Pose found = pose->frame_from_child * base_from_rig();
  const Vec3 left = found.translation - world_from_rig.translation;
  EXPECT_NEAR(off_by(*pose).z(), 0, 1e-3);
  EXPECT_LT(std::abs(left.dot(ahead)), 1.5e-3);
  const Vec3 before = (localised(time) * base_from_rig()).translation - world_from_rig.translation;
  EXPECT_GT(std::abs(before.dot(sideways)), 0.01);
  EXPECT_NEAR(left.dot(sideways), before.dot(sideways), 6e-3);  // the lever arm of the rotation is known
  // The covariance says so: of the base's place along the wall it is that of the localiser.
  const Vec6 sigma = correction.status().sigma;
  EXPECT_GT(std::max(sigma[3], sigma[4]), 0.012);
  EXPECT_LT(sigma[2], 2e-3);
}

TEST(PoseCorrection, AnErrorFadesWithItsCorrelationTime) {
  PoseCorrectionOptions slow = options();
  slow.correlation = 2;
  PoseCorrection correction(slow);
  drive(correction, 10, 12);
  ASSERT_TRUE(correction.add(sight(11.9, MatX::Identity(6, 6))));
  EXPECT_FALSE(correction.add(message(12.0))) << "images come: they carry the localiser's messages";
  for (double time = 12.1; time < 13.85; time += 0.1) correction.add(message(time));
  const auto alone = correction.add(message(13.9));
  ASSERT_TRUE(alone);
  const double left = 1 - std::exp(-1.0);
  EXPECT_NEAR(off_by(*alone).x(), 0.021 * left, 2e-3);
  EXPECT_NEAR(off_by(*alone).y(), -0.017 * left, 2e-3);
  EXPECT_NEAR(off_by(*alone).z(), 0.012 * left, 1e-3);
}

TEST(PoseCorrection, AnImageBeyondTheStatedErrorIsRefused) {
  PoseCorrection correction(options());
  drive(correction, 10, 12);
  ASSERT_TRUE(correction.add(sight(11.5, MatX::Identity(6, 6))));
  PoseSight wrong = sight(11.6, MatX::Identity(6, 6));
  Vec6 moved = Vec6::Zero();
  moved[3] = 0.4;
  wrong.score += wrong.information * moved;
  EXPECT_FALSE(correction.add(wrong));
  EXPECT_EQ(correction.status().refused, 1u);
  EXPECT_EQ(correction.status().taken, 1u);
  EXPECT_NEAR(correction.status().error[3], -0.021, 3e-3);
}

TEST(PoseCorrection, WithoutImagesItIsTheLocaliser) {
  PoseCorrection correction(options());
  EXPECT_FALSE(correction.add(sight(10, MatX::Identity(6, 6)))) << "no message has come";
  drive(correction, 10, 12);
  const auto pose = correction.add(message(12.0));
  ASSERT_TRUE(pose);
  EXPECT_NEAR(off_by(*pose).x(), 0.021, 2e-3);
  // Odometry is handed on with the localiser's poses, at their moments, and not with those of images.
  StampedPose with_odometry = message(12.1);
  with_odometry.twist = (Vec6() << 0, 0, 0.3, 0.44, 0.02, 0).finished();
  const auto moving = correction.add(with_odometry);
  ASSERT_TRUE(moving && moving->twist);
  EXPECT_EQ(*moving->twist, *with_odometry.twist);
  const auto seen = correction.add(sight(12.08, MatX::Identity(6, 6)));
  ASSERT_TRUE(seen);
  EXPECT_FALSE(seen->twist);
  EXPECT_THROW(PoseCorrection([] {
                 PoseCorrectionOptions bad;
                 bad.correlation = 0;
                 return bad;
               }()),
               std::invalid_argument);
}

/// What wheels state of truth().
Vec6 twist_of(double time) {
  constexpr double kStep = 1e-4;
  return se3_log(Pose(truth(time).inverse() * truth(time + kStep))) / kStep;
}
StampedPose with_twist(double time, const Off& off = {}) {
  StampedPose result = message(time, off);
  result.twist = twist_of(time);
  return result;
}

TEST(PoseCorrection, OdometryCarriesThePoseWhereNoImageCorrectsIt) {
  PoseCorrection with(options()), without(options());
  const auto both = [&](double time, const Off& off) {
    without.add(message(time, off));
    return with.add(with_twist(time, off));
  };
  for (double time = 10; time < 12; time += 0.1) both(time, {});
  const PoseSight all = sight(11.86, MatX::Identity(6, 6));
  ASSERT_TRUE(without.add(all));
  const auto seen = with.add(all);
  ASSERT_TRUE(seen);
  EXPECT_LT(off_by(*seen).head<2>().norm(), 1e-3);
  EXPECT_NEAR(off_by(*seen).z(), 0, 3e-4);
  EXPECT_NEAR(with.status().error[3], -0.021, 3e-3);
  EXPECT_NEAR(with.status().error[2], -0.012, 2e-3);
  EXPECT_LT(with.status().sigma[3], 8e-3);
  // The localiser comes to believe something else. The robot knows that it has not been there.
  std::optional<StampedPose> last, last_without;
  for (double time = 12; time < 13.05; time += 0.1) {
    const double share = time - 12;
    const Off off{0.021 - 0.03 * share, -0.017 + 0.025 * share, 0.012 - 0.02 * share};
    last_without = without.add(message(time, off));
    last = with.add(with_twist(time, off));
  }
  ASSERT_TRUE(last && last_without);
  EXPECT_LT(off_by(*last).head<2>().norm(), 0.75 * off_by(*last_without).head<2>().norm());
  EXPECT_LT(std::abs(off_by(*last).z()), 0.55 * std::abs(off_by(*last_without).z()));
}

TEST(PoseCorrection, WhileImagesComeAMessageTellsItsTwistAlone) {
  PoseCorrection correction(options());
  for (double time = 10; time < 12; time += 0.1) {
    const auto pose = correction.add(with_twist(time));
    ASSERT_TRUE(pose && pose->covariance && pose->twist);
    EXPECT_LT(pose->covariance->diagonal().minCoeff(), 1) << "no image has come";
  }
  ASSERT_TRUE(correction.add(sight(11.95, MatX::Identity(6, 6))));
  const auto pose = correction.add(with_twist(12));
  ASSERT_TRUE(pose && pose->covariance && pose->twist);
  EXPECT_GE(pose->covariance->diagonal().minCoeff(), kUnknownPoseVariance);
  EXPECT_EQ(*pose->twist, twist_of(12));
  EXPECT_LT(off_by(*pose).head<2>().norm(), 2e-3) << "a reader who ignores the covariance gets the best pose";
}

TEST(PoseCorrection, OfTwoSightsOfAnImageOnePoseIsGiven) {
  PoseCorrection correction(options()), one_by_one(options());
  for (double time = 10; time < 12; time += 0.1)
    correction.add(with_twist(time)), one_by_one.add(with_twist(time));
  MatX along = MatX::Zero(6, 4), across = MatX::Zero(6, 2);
  along(0, 0) = along(1, 1) = along(5, 2) = along(2, 3) = 1;
  across(3, 0) = across(4, 1) = 1;
  const std::vector<PoseSight> sights = {sight(11.97, along), sight(11.97, across)};
  const auto together = correction.add(sights);
  one_by_one.add(sights[0]);
  const auto second = one_by_one.add(sights[1]);
  ASSERT_TRUE(together && second);
  EXPECT_EQ(together->frame_from_child.translation, second->frame_from_child.translation);
  EXPECT_LT(off_by(*together).head<2>().norm(), 1e-3);
  EXPECT_FALSE(correction.add(std::vector<PoseSight>()));
}

/// Some drivers fill in zeros, or the twist of the world's axes.
TEST(PoseCorrection, ATwistThatContradictsThePosesIsNotUsed) {
  for (const Vec6& stated : {Vec6(Vec6::Zero()), Vec6(-2 * twist_of(0))}) {
    PoseCorrection correction(options());
    PoseTrack track(options().track);
    double worst = 0;
    for (double time = 10; time < 16; time += 0.1) {
      StampedPose from = message(time);
      from.twist = stated;
      if (const auto pose = correction.add(from)) track.add(*pose);
      if (const auto pose = correction.add(sight(time - 0.03, MatX::Identity(6, 6)))) {
        track.add(*pose);
        if (time > 13) worst = std::max(worst, off_by(*pose).head<2>().norm());
      }
    }
    EXPECT_GT(correction.status().taken, 45u);
    EXPECT_LT(worst, 2e-3);
    EXPECT_LT((track.at(16).frame_from_child.translation - truth(16).translation).norm(), 0.02);
  }
}

/// Two hundred drives: the squared error of a pose over the covariance that is stated with it, three components.
TEST(PoseCorrection, ThePoseByOdometryIsAsFarOffAsStated) {
  std::mt19937_64 random(4711);
  std::normal_distribution<double> normal;
  double sum = 0;
  int count = 0, beyond = 0;
  for (int drive_number = 0; drive_number < 200; ++drive_number) {
    PoseCorrectionOptions chosen = options();
    PoseCorrection correction(chosen);
    const Vec3 sigma(chosen.position_sigma, chosen.position_sigma, chosen.rotation_sigma);
    const double phi = std::exp(-0.1 / chosen.correlation), scale = 1 + 0.02 * normal(random);
    Vec3 error = sigma.cwiseProduct(Vec3(normal(random), normal(random), normal(random)));
    for (int i = 0; i < 60; ++i) {
      const double time = 10 + 0.1 * i;
      for (int k = 0; k < 3; ++k)
        error[k] = phi * error[k] + std::sqrt(1 - phi * phi) * sigma[k] * normal(random);
      StampedPose from = with_twist(time, {error[0], error[1], error[2]});
      *from.twist *= scale;
      for (const int k : {2, 3, 4})
        (*from.twist)[k] += (k == 2 ? chosen.track.turn_sigma : chosen.track.speed_sigma) * normal(random);
      correction.add(from);
      // One wall, then for a second both, then none.
      if (i % 30 >= 20) continue;
      MatX directions = MatX::Zero(6, i % 30 < 10 ? 3 : 6);
      if (i % 30 < 10)
        directions(0, 0) = directions(1, 1) = directions(5, 2) = 1;
      else
        directions.setIdentity();
      PoseSight seen = sight(time - 0.04, directions, {error[0], error[1], error[2]});
      for (Eigen::Index k = 0; k < directions.cols(); ++k)
        seen.score += 1e3 * directions.col(k) * normal(random);
      const auto pose = correction.add(seen);
      if (!pose || i < 30) continue;
      const Pose wrong = pose->frame_from_child * truth(seen.time).inverse();
      const Vec6 xi = se3_log(wrong);
      const double chi2 = xi.dot(pose->covariance->ldlt().solve(xi));
      sum += chi2, ++count, beyond += chi2 > 22.5;  // 1 in 1000 of six degrees of freedom
    }
  }
  // Of the six directions three have no error: height and tilts are stated to two millimetres and milliradians. The
  // scale's share of the noise is for worse wheels.
  EXPECT_GT(sum / count, 1.5);
  EXPECT_LT(sum / count, 4.5);
  EXPECT_LT(beyond, count / 100);
}

}  // namespace
}  // namespace procam::track
