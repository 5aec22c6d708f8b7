#include "ros2_output.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "dds/ros2_peer.hpp"
#include "live_world.hpp"
#include "support/lopsided.hpp"

namespace procam::show {
namespace {

/// After a correction (watch/correction.hpp) others must not aim by the pose of the rig file.
TEST(Ros2Output, ACorrectedProjectorHasItsCorrectedFrame) {
  const test::LoopbackDomain domain;
  Rig rig = small_rig();
  RigProjector second = rig.projectors.front();
  second.name = "other_lamp";
  second.rig_from_projector = Pose(so3_exp(Vec3(0.2, 0.1, -0.1)), Vec3(-0.4, 0.1, 0.2));
  rig.projectors.push_back(second);
  ShowOptions options;
  options.projector = "wall_lamp";
  options.publish = "ros2:/procam";
  const Pose world_from_rig(so3_exp(Vec3(0.02, 0.1, -0.03)), Vec3(0.1, 0.05, -0.2));
  const Ros2Output output(options, rig, Pose(), world_from_rig);
  ProjectionOptions standing;
  standing.projector = "wall_lamp";
  standing.projector_from_world = (world_from_rig * rig.projector("wall_lamp").rig_from_projector).inverse();
  Projection projection(rig, standing);
  projection.set_show(small_show());
  const auto placed = [&](const std::string& frame) {
    const std::vector<FrameTree::Link> links = output.frames(projection);
    const auto found =
        std::find_if(links.begin(), links.end(), [&](const auto& link) { return link.source == frame; });
    EXPECT_NE(found, links.end()) << frame;
    return found == links.end() ? Pose() : found->target_from_source.pose;
  };
  EXPECT_EQ(placed("procam/wall_lamp").matrix(), rig.projector("wall_lamp").rig_from_projector.matrix());
  const Pose corrected = Pose(so3_exp(Vec3(0.004, -0.003, 0.001)), Vec3(0.002, 0, 0.001)) *
                         rig.projector("wall_lamp").rig_from_projector;
  projection.move_projector(corrected);
  EXPECT_EQ(placed("procam/wall_lamp").matrix(), corrected.matrix());
  EXPECT_EQ(placed("procam/other_lamp").matrix(), second.rig_from_projector.matrix());
}

}  // namespace
}  // namespace procam::show
