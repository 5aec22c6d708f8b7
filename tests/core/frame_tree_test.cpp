#include "procam/core/geometry/frame_tree.hpp"

#include <gtest/gtest.h>

#include "support/lopsided.hpp"

namespace procam {
namespace {

/// world -> robot -> rig -> {camera -> marker, projector}; shelf stands alone.
class FrameTreeOfARobot : public ::testing::Test {
 protected:
  FrameTreeOfARobot() {
    std::mt19937_64 random(9);
    for (PoseWithCovariance* pose :
         {&world_from_robot, &robot_from_rig, &rig_from_camera, &camera_from_marker, &rig_from_projector}) {
      pose->pose = test::random_pose(random);
      Mat6 root;
      for (int i = 0; i < 36; ++i) root(i / 6, i % 6) = 0.01 * test::uniform(random, -1, 1);
      pose->covariance = root * root.transpose();
    }
    // Not from the root downwards: the order of arrival does not matter.
    frames.set("camera", "marker", camera_from_marker);
    frames.set("rig", "projector", rig_from_projector);
    frames.set("world", "robot", world_from_robot);
    frames.set("rig", "camera", rig_from_camera);
    frames.set("robot", "rig", robot_from_rig);
    frames.set("room", "shelf", Pose(test::lopsided_pose()));
  }
  static void expect_same(const PoseWithCovariance& a, const PoseWithCovariance& b) {
    EXPECT_LT((a.pose.matrix() - b.pose.matrix()).norm(), 1e-13);
    EXPECT_LT((a.covariance - b.covariance).norm(), 1e-12 * (1 + b.covariance.norm()));
  }
  FrameTree frames;
  PoseWithCovariance world_from_robot, robot_from_rig, rig_from_camera, camera_from_marker,
      rig_from_projector;
};

TEST_F(FrameTreeOfARobot, ChainsUpwards) {
  expect_same(
      frames.get("world", "marker"),
      compose(compose(compose(world_from_robot, robot_from_rig), rig_from_camera), camera_from_marker));
}

TEST_F(FrameTreeOfARobot, InvertsEdgesOnTheWayDown) {
  expect_same(frames.get("marker", "robot"), inverse(frames.get("robot", "marker")));
  expect_same(frames.get("camera", "rig"), inverse(rig_from_camera));
}

TEST_F(FrameTreeOfARobot, TurnsRoundAtTheNearestCommonFrame) {
  expect_same(frames.get("projector", "marker"),
              compose(compose(inverse(rig_from_projector), rig_from_camera), camera_from_marker));
  const auto chain = frames.chain("projector", "marker");
  ASSERT_EQ(chain.size(), 3u);  // the robot's and the world's uncertainty stay out of it
  EXPECT_EQ(chain[0].target + " " + chain[0].source, "projector rig");
  EXPECT_EQ(chain[1].target + " " + chain[1].source, "rig camera");
  EXPECT_EQ(chain[2].target + " " + chain[2].source, "camera marker");
}

TEST_F(FrameTreeOfARobot, AFrameFromItselfIsTheIdentity) {
  EXPECT_TRUE(frames.chain("camera", "camera").empty());
  expect_same(frames.get("camera", "camera"), PoseWithCovariance{});
}

TEST_F(FrameTreeOfARobot, AnEdgeIsReplacedByItsNextValue) {
  const Pose moved = test::other_lopsided_pose();
  frames.set("world", "robot", moved);
  expect_same(frames.get("world", "robot"), {moved, Mat6::Zero()});
}

template <typename F>
Error thrown_by(const F& f) {
  try {
    f();
  } catch (const Error& error) {
    return error;
  }
  return Error(ErrorKind::kIo, "nothing was thrown", "", "");
}

TEST_F(FrameTreeOfARobot, RefusesASecondParent) {
  const Error error = thrown_by([&] { frames.set("projector", "marker", Pose()); });
  EXPECT_EQ(error.kind(), ErrorKind::kInput);
  EXPECT_NE(error.why().find("'camera'"), std::string::npos) << error.what();
  expect_same(frames.get("camera", "marker"), camera_from_marker);
}

TEST_F(FrameTreeOfARobot, RefusesALoop) {
  EXPECT_EQ(thrown_by([&] { frames.set("marker", "world", Pose()); }).kind(), ErrorKind::kInput);
  EXPECT_EQ(thrown_by([&] { frames.set("shelf", "room", Pose()); }).kind(), ErrorKind::kInput);
  EXPECT_EQ(thrown_by([&] { frames.set("new", "new", Pose()); }).kind(), ErrorKind::kInput);
}

TEST_F(FrameTreeOfARobot, RefusesFramesThatNothingJoins) {
  const Error error = thrown_by([&] { frames.get("projector", "shelf"); });
  EXPECT_EQ(error.kind(), ErrorKind::kInput);
  EXPECT_EQ(error.next(), "give the pose between 'world' and 'room'");
  EXPECT_EQ(thrown_by([&] { frames.get("camera", "nowhere"); }).kind(), ErrorKind::kInput);
  frames.set("world", "room", Pose());
  EXPECT_NO_THROW(frames.get("projector", "shelf"));
}

TEST_F(FrameTreeOfARobot, RefusesAPoseThatIsNotFinite) {
  PoseWithCovariance bad = world_from_robot;
  bad.pose.translation.x() = std::nan("");
  EXPECT_THROW(frames.set("world", "robot", bad), std::invalid_argument);
  bad = world_from_robot;
  bad.covariance(3, 3) = INFINITY;
  EXPECT_THROW(frames.set("world", "robot", bad), std::invalid_argument);
  expect_same(frames.get("world", "robot"), world_from_robot);
}

}  // namespace
}  // namespace procam
