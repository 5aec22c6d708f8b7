#include "procam/simulate/drive.hpp"

#include <gtest/gtest.h>

#include "../support/lopsided.hpp"

namespace procam::simulate {
namespace {

using procam::test::lopsided_pose;
using procam::test::other_lopsided_pose;

Vec6 lopsided_twist() {
  return (Vec6() << 0.21, -0.34, 0.52, 0.4, -0.13, 0.07).finished();
}

Drive lopsided_drive() {
  Leg smooth{0.7 * lopsided_twist(), 1.3, true};
  return Drive(lopsided_pose(), {constant_twist(lopsided_twist(), 1.7), smooth, circle(-0.8, 0.5, 0.3)}, 2.4);
}

double distance(const Pose& a, const Pose& b) {
  return se3_log(a.inverse() * b).norm();
}

TEST(Drive, PosesAreTheTwistIntegrated) {
  const Drive drive = lopsided_drive();
  Pose pose = drive.world_from_rig(drive.start_time());
  const int steps = 40000;
  const double dt = (drive.end_time() - drive.start_time()) / steps;
  for (int i = 0; i < steps; ++i) {
    const double time = drive.start_time() + i * dt;
    // The midpoint rule: right to dt^2 times the twist's curvature, and to a step at the joints.
    pose = (pose * se3_exp(Vec6(drive.twist(time + 0.5 * dt) * dt))).normalized();
    if (i % 4000 == 0) {
      EXPECT_LT(distance(pose, drive.world_from_rig(time + dt)), 2e-4) << time;
    }
  }
  EXPECT_LT(distance(pose, drive.world_from_rig(drive.end_time())), 2e-4);
}

TEST(Drive, TheTwistActsOnTheRight) {
  const Drive drive(lopsided_pose(), {constant_twist(lopsided_twist(), 3)}, -1);
  EXPECT_LT(distance(drive.world_from_rig(0.5), lopsided_pose() * se3_exp(Vec6(1.5 * lopsided_twist()))),
            1e-12);
  EXPECT_LT((drive.twist(0.5) - lopsided_twist()).norm(), 1e-12);
  const double h = 1e-5;  // central difference: h^2 = 1e-10, and rounding 1e-11
  for (const double time : {-0.7, 0.4, 1.9}) {
    const Pose before = drive(time - h), after = drive(time + h);
    EXPECT_LT((se3_log(before.inverse() * after) / (2 * h) - drive.twist(time)).norm(), 1e-9);
  }
}

TEST(Drive, StandsStillBeforeAndAfter) {
  const Drive drive = lopsided_drive();
  EXPECT_LT(distance(drive(0), lopsided_pose()), 1e-12);
  EXPECT_LT(distance(drive(99), drive(drive.end_time())), 1e-12);
  EXPECT_EQ(drive.twist(2.39).norm(), 0);
  EXPECT_EQ(drive.twist(drive.end_time()).norm(), 0);
  EXPECT_GT(drive.twist(2.4).norm(), 0);
}

TEST(Drive, ACircleClosesAtItsRadiusAndSpeed) {
  const Leg leg = circle(0.8, 0.5);
  const Drive drive(lopsided_pose(), {leg});
  EXPECT_NEAR(leg.duration, 2 * M_PI * 0.8 / 0.5, 1e-12);
  EXPECT_LT(distance(drive(leg.duration), drive(0)), 1e-12);
  const Vec3 centre = lopsided_pose() * Vec3(0, 0.8, 0);  // a positive radius turns left
  for (double t = 0; t < leg.duration; t += 0.4) {
    EXPECT_NEAR((drive(t).translation - centre).norm(), 0.8, 1e-12);
    EXPECT_NEAR(drive.twist(t).tail<3>().norm(), 0.5, 1e-12);
  }
  const Vec3 right = Drive(Pose(), {circle(-0.8, 0.5, 0.25)})(99).translation;
  EXPECT_NEAR((right - Vec3(0.8, -0.8, 0)).norm(), 0, 1e-12);
}

TEST(Drive, PassesWaypointsInTimeAndAtRest) {
  const std::vector<Waypoint> waypoints{{lopsided_pose(), 1}, {other_lopsided_pose(), 3.5}, {Pose(), 4.1}};
  const Drive drive = drive_through(waypoints);
  EXPECT_EQ(drive.start_time(), 1);
  EXPECT_NEAR(drive.end_time(), 4.1, 1e-12);
  for (const Waypoint& w : waypoints) {
    EXPECT_LT(distance(drive(w.time), w.world_from_rig), 1e-12);
    EXPECT_LT(drive.twist(w.time).norm(), 1e-12);
    EXPECT_LT(drive.twist(w.time - 1e-4).norm(), 1e-5);  // and smoothly: the twist starts with t^2
  }
  EXPECT_GT(drive.twist(2.2).norm(), 1);
}

TEST(Drive, RefusesLegsThatCannotBe) {
  EXPECT_THROW(Drive(Pose(), {Leg{Vec6::Zero(), 0, false}}), std::invalid_argument);
  EXPECT_THROW(circle(0, 1), std::invalid_argument);
  EXPECT_THROW(circle(1, 0), std::invalid_argument);
  EXPECT_THROW(drive_through({{Pose(), 0}}), std::invalid_argument);
  EXPECT_THROW(drive_through({{Pose(), 1}, {Pose(), 1}}), std::invalid_argument);
  EXPECT_THROW(localise(lopsided_drive(), {0}), std::invalid_argument);
  Localiser negative;
  negative.position_sigma = -1;
  EXPECT_THROW(localise(lopsided_drive(), negative), std::invalid_argument);
}

TEST(Localise, SaysTheTruthWithTheNoiseAndTheDelayAskedFor) {
  const Drive drive(lopsided_pose(), {constant_twist(lopsided_twist(), 400)}, 3);
  Localiser localiser{25, 0.1, 0.01, 0.02, 0.006, 0.3, 17};
  const std::vector<LocalisedPose> messages = localise(drive, localiser);
  Vec3 shift = Vec3::Zero(), shift2 = Vec3::Zero(), turn = Vec3::Zero(), turn2 = Vec3::Zero();
  double delay = 0, delay2 = 0;
  for (const LocalisedPose& m : messages) {
    EXPECT_LT(distance(m.truth, drive(m.stamp)), 1e-12);
    const Vec3 e = m.measured.translation - m.truth.translation;
    const Vec3 w = so3_log(Eigen::Quaterniond(m.truth.rotation.conjugate() * m.measured.rotation));
    shift += e;
    shift2 += e.cwiseAbs2();
    turn += w;
    turn2 += w.cwiseAbs2();
    delay += m.arrival - m.stamp;
    delay2 += std::pow(m.arrival - m.stamp - 0.1, 2);
  }
  // All limits 4.4 sigma: a false alarm in 1e5 each.
  const double n = double(messages.size()), sent = 400 * 25 + 1;
  EXPECT_NEAR(n, 0.7 * sent, 4.4 * std::sqrt(sent * 0.3 * 0.7));
  EXPECT_NEAR(delay / n, 0.1, 4.4 * 0.01 / std::sqrt(n));
  EXPECT_NEAR(delay2 / n, 1e-4, 4.4e-4 * std::sqrt(2 / n));
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(shift[i] / n, 0, 4.4 * 0.02 / std::sqrt(n));
    EXPECT_NEAR(shift2[i] / n, 4e-4, 4.4 * 4e-4 * std::sqrt(2 / n));
    EXPECT_NEAR(turn[i] / n, 0, 4.4 * 0.006 / std::sqrt(n));
    EXPECT_NEAR(turn2[i] / n, 3.6e-5, 4.4 * 3.6e-5 * std::sqrt(2 / n));
  }
}

TEST(Localise, GivesThemAsTheyArrive) {
  const Drive drive = lopsided_drive();
  Localiser localiser{40, 0.02, 0.05, 0, 0, 0, 5};
  const std::vector<LocalisedPose> messages = localise(drive, localiser);
  EXPECT_EQ(messages.size(), std::size_t((drive.end_time() - drive.start_time()) * 40) + 1);
  int overtaken = 0;
  for (std::size_t i = 0; i < messages.size(); ++i) {
    EXPECT_GE(messages[i].arrival, messages[i].stamp);
    if (i == 0) continue;
    EXPECT_GE(messages[i].arrival, messages[i - 1].arrival);
    overtaken += messages[i].stamp < messages[i - 1].stamp;
  }
  EXPECT_GT(overtaken, 3);
}

TEST(Localise, DroppingChangesNothingInTheOthers) {
  Localiser localiser{40, 0.02, 0.005, 0.01, 0.01, 0, 5};
  const std::vector<LocalisedPose> all = localise(lopsided_drive(), localiser);
  localiser.dropped = 0.5;
  const std::vector<LocalisedPose> some = localise(lopsided_drive(), localiser);
  EXPECT_LT(some.size(), 0.8 * double(all.size()));
  EXPECT_GT(some.size(), 0.2 * double(all.size()));
  std::size_t i = 0;
  for (const LocalisedPose& message : some) {
    while (i < all.size() && all[i].stamp != message.stamp) ++i;
    ASSERT_LT(i, all.size());
    EXPECT_EQ(all[i].arrival, message.arrival);
    EXPECT_EQ((all[i].measured.matrix() - message.measured.matrix()).norm(), 0);
  }
  localiser.seed = 6;
  EXPECT_NE(localise(lopsided_drive(), localiser).front().arrival, some.front().arrival);
}

}  // namespace
}  // namespace procam::simulate
