#include "transform_buffer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "procam/core/base/limits.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::dds::internal {
namespace {

/// A pose about no axis, different for each k.
Pose some_pose(double k) {
  Vec6 xi;
  xi << 0.3 + 0.1 * k, -0.2, 0.5 - 0.05 * k, 1 + k, -2, 0.7 * k;
  return se3_exp(xi);
}

track::StampedPose edge(const char* frame, const char* child, double stamp, const Pose& pose) {
  track::StampedPose message;
  message.frame = frame;
  message.child = child;
  message.stamp = stamp;
  message.frame_from_child = pose;
  return message;
}

void expect_equal(const Pose& a, const Pose& b, double tolerance = 1e-12) {
  EXPECT_LT((a.matrix() - b.matrix()).cwiseAbs().maxCoeff(), tolerance);
}

TEST(TransformBuffer, ChainsGoUpAndDownByStaticAndMovingEdges) {
  TransformBuffer buffer;
  const Pose earth_from_map = some_pose(1), map_from_odom = some_pose(2), odom_from_base = some_pose(3),
             base_from_projector = some_pose(4), map_from_dock = some_pose(5);
  EXPECT_EQ(buffer.set(edge("base", "projector", 0, base_from_projector), true), nullptr);
  EXPECT_EQ(buffer.set(edge("odom", "base", 10, odom_from_base), false), nullptr);
  EXPECT_FALSE(buffer.latest("map", "projector"));
  EXPECT_EQ(buffer.set(edge("map", "odom", 10, map_from_odom), false), nullptr);
  EXPECT_EQ(buffer.set(edge("earth", "map", 0, earth_from_map), true), nullptr);
  EXPECT_EQ(buffer.set(edge("map", "dock", 0, map_from_dock), true), nullptr);
  EXPECT_EQ(buffer.latest("dock", "projector"), 10);
  const auto dock_from_projector = buffer.lookup("dock", "projector", 10);
  ASSERT_TRUE(dock_from_projector);
  expect_equal(*dock_from_projector,
               map_from_dock.inverse() * map_from_odom * odom_from_base * base_from_projector);
  expect_equal(*buffer.lookup("projector", "dock", 10), dock_from_projector->inverse());
  expect_equal(*buffer.lookup("base", "odom", 10), odom_from_base.inverse());
  // A chain of static edges holds at all times; frames that never came have none.
  EXPECT_EQ(buffer.latest("dock", "earth"), std::numeric_limits<double>::infinity());
  expect_equal(*buffer.lookup("earth", "dock", 1e9), earth_from_map * map_from_dock);
  EXPECT_FALSE(buffer.lookup("dock", "moon", 10));
  expect_equal(*buffer.lookup("base", "base", 10), Pose());
}

TEST(TransformBuffer, InterpolatesBetweenStampsAndNeverBeyond) {
  TransformBuffer buffer;
  const Pose before = some_pose(0), after = some_pose(1);
  // The second quaternion has the other sign: the same rotation, and the shorter arc counts.
  Pose flipped = after;
  flipped.rotation.coeffs() *= -1;
  buffer.set(edge("odom", "base", 20, before), false);
  buffer.set(edge("odom", "base", 21, flipped), false);
  buffer.set(edge("map", "odom", 20.25, some_pose(2)), false);
  buffer.set(edge("map", "odom", 22, some_pose(2)), false);
  EXPECT_EQ(buffer.latest("map", "base"), 21);
  const auto between = buffer.lookup("odom", "base", 20.3);
  ASSERT_TRUE(between);
  EXPECT_LT((between->translation - (0.7 * before.translation + 0.3 * after.translation)).norm(), 1e-12);
  const Vec3 arc = so3_log(Eigen::Quaterniond(before.rotation.conjugate() * after.rotation));
  const Eigen::Quaterniond expected = before.rotation * so3_exp(Vec3(0.3 * arc));
  EXPECT_LT(expected.angularDistance(between->rotation), 1e-12);
  for (const double time : {19.999, 21.001}) EXPECT_FALSE(buffer.lookup("odom", "base", time)) << time;
  for (const double time : {20.2, 21.5}) EXPECT_FALSE(buffer.lookup("map", "base", time)) << time;
  EXPECT_TRUE(buffer.lookup("map", "base", 20.25));
}

TEST(TransformBuffer, TakesStampsInAnyOrderAndForgetsOldOnes) {
  TransformBuffer buffer(2);
  for (const double stamp : {5., 7., 6., 6.5})
    buffer.set(edge("odom", "base", stamp, some_pose(stamp)), false);
  expect_equal(*buffer.lookup("odom", "base", 6.5), some_pose(6.5));
  expect_equal(*buffer.lookup("odom", "base", 6), some_pose(6));
  buffer.set(edge("odom", "base", 8.5, some_pose(0)), false);
  EXPECT_FALSE(buffer.lookup("odom", "base", 6.4));
  EXPECT_TRUE(buffer.lookup("odom", "base", 6.5));
  // The clock is set back by more than the buffer spans: it begins anew.
  buffer.set(edge("odom", "base", 1, some_pose(3)), false);
  EXPECT_EQ(buffer.latest("odom", "base"), 1);
}

TEST(TransformBuffer, RefusesLoopsAndTooManyFramesAndFollowsANewParent) {
  TransformBuffer buffer;
  EXPECT_EQ(buffer.set(edge("a", "b", 1, some_pose(1)), false), nullptr);
  EXPECT_EQ(buffer.set(edge("b", "c", 1, some_pose(2)), false), nullptr);
  EXPECT_STREQ(buffer.set(edge("c", "a", 1, some_pose(3)), false), "loop of frames");
  EXPECT_STREQ(buffer.set(edge("c", "c", 1, some_pose(3)), false), "loop of frames");
  EXPECT_EQ(buffer.set(edge("d", "c", 2, some_pose(4)), false), nullptr);
  EXPECT_FALSE(buffer.latest("a", "c"));
  EXPECT_EQ(buffer.latest("d", "c"), 2);
  const char* why = nullptr;
  for (int k = 0; k < 2 * int(limits::kTransformFrames) && why == nullptr; ++k)
    why = buffer.set(edge("a", ("frame" + std::to_string(k)).c_str(), 1, some_pose(1)), false);
  EXPECT_STREQ(why, "too many frames");
  EXPECT_EQ(buffer.size(), limits::kTransformFrames);
  for (int k = 0; k < 3 * int(limits::kTransformStamps); ++k)
    EXPECT_EQ(buffer.set(edge("a", "b", 1 + 1e-4 * k, some_pose(1)), false), nullptr);
  EXPECT_FALSE(buffer.lookup("a", "b", 1));
}

/// A robot that drives ever faster along a spiral; a lamp on it is off its axis.
Vec6 driven_twist(double t) {
  return (Vec6() << 0, 0, 0.4 - 0.1 * t, 0.3 + 0.2 * t, 0, 0).finished();
}
Pose driven(double t) {
  Pose pose = some_pose(1);
  constexpr double kStep = 1e-3;
  for (int k = 0; k < int(t / kStep + 0.5); ++k)
    pose = (pose * se3_exp(Vec6(kStep * driven_twist((k + 0.5) * kStep)))).normalized();
  return pose;
}
Vec6 at_lamp(const Vec6& twist, const Pose& base_from_lamp) {
  const Mat3 lamp_from_base = base_from_lamp.rotation.conjugate().toRotationMatrix();
  Vec6 moved;
  moved << lamp_from_base * twist.head<3>(),
      lamp_from_base * (twist.tail<3>() + twist.head<3>().cross(base_from_lamp.translation));
  return moved;
}

TEST(TransformBuffer, GivesTheTwistOfADriveByItsOdometry) {
  for (const double interval : {0.02, 0.1}) {
    TransformBuffer buffer;
    buffer.set(edge("base", "lamp", 0, some_pose(3)), true);
    double time = 0;
    EXPECT_FALSE(buffer.twist("odom", "lamp", 0));
    for (int k = 0; time < 2; ++k) {
      time = interval * k;
      buffer.set(edge("odom", "base", time, driven(time)), false);
      // The localiser jumps with each message.
      buffer.set(edge("map", "odom", time, some_pose(k % 3)), false);
    }
    const auto odometry = buffer.odometry_frame("map", "lamp");
    ASSERT_EQ(odometry, "odom");
    const auto twist = buffer.twist(*odometry, "lamp", time);
    ASSERT_TRUE(twist);
    const Vec6 expected = at_lamp(driven_twist(time), some_pose(3));
    EXPECT_LT((*twist - expected).norm(), 0.01 * expected.norm()) << interval;
    EXPECT_GT((*twist - at_lamp(driven_twist(time - 0.05), some_pose(3))).norm(), 0.01 * expected.norm());
  }
}

TEST(TransformBuffer, NoTwistWithoutOdometryOrAfterAGap) {
  TransformBuffer buffer;
  buffer.set(edge("map", "robot1/odom", 0, some_pose(2)), true);
  buffer.set(edge("robot1/odom", "robot1/base", 1, driven(1)), false);
  buffer.set(edge("robot1/base", "arm", 0, some_pose(3)), true);
  buffer.set(edge("map", "modom", 0, some_pose(4)), true);
  buffer.set(edge("modom", "cart", 0, some_pose(4)), true);
  EXPECT_EQ(buffer.odometry_frame("map", "arm"), "robot1/odom");
  EXPECT_EQ(buffer.odometry_frame("robot1/odom", "arm"), "robot1/odom");
  EXPECT_FALSE(buffer.odometry_frame("map", "cart")) << "another name that ends alike";
  EXPECT_FALSE(buffer.odometry_frame("robot1/base", "arm")) << "the frame moves with the child";
  EXPECT_FALSE(buffer.odometry_frame("cart", "arm")) << "not above the child";
  EXPECT_FALSE(buffer.twist("robot1/odom", "arm", 1)) << "one stamp";
  buffer.set(edge("robot1/odom", "robot1/base", 1.02, driven(1.02)), false);
  EXPECT_FALSE(buffer.twist("robot1/odom", "arm", 1.02)) << "too short a history";
  buffer.set(edge("robot1/odom", "robot1/base", 1.2, driven(1.2)), false);
  buffer.set(edge("robot1/odom", "robot1/base", 1.3, driven(1.3)), false);
  EXPECT_TRUE(buffer.twist("robot1/odom", "arm", 1.3));
  buffer.set(edge("robot1/odom", "robot1/base", 2.1, driven(2.1)), false);
  EXPECT_FALSE(buffer.twist("robot1/odom", "arm", 2.1)) << "a gap";
}

}  // namespace
}  // namespace procam::dds::internal
