#include "ros2_output.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <thread>

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

/// A tracked surface is where it is seen, in a moving frame; its place in the surface file is not announced.
TEST(Ros2Output, ATrackedSurfaceIsAMovingFrame) {
  const test::LoopbackDomain domain;
  const Rig rig = small_rig();
  ShowOptions options;
  options.publish = "ros2:/procam";
  options.track.emplace().surfaces = {{"left,right", "apriltag_36h11:5:100mm"}};
  Ros2Output output(options, rig, Pose(), Pose());
  ProjectionOptions moving;
  moving.projector_from_world = rig.projector().rig_from_projector.inverse();
  moving.moving.surfaces = {{{"left", "right"}, {}}};
  Projection projection(rig, moving);
  Show show = small_show();
  show.surfaces.surfaces[2].name = "sign";
  projection.set_show(std::move(show));
  ImageU8 frame(projection.frame_size(), 3);
  projection.draw(100, 0, frame);
  EXPECT_TRUE(output.moving_frames(projection).empty()) << "not seen yet";
  for (const FrameTree::Link& link : output.frames(projection))
    EXPECT_EQ(link.source.find("surfaces/"), std::string::npos) << link.source;

  track::StampedPose sighting = message(100, Pose(so3_exp(Vec3(0.1, 0.3, -0.07)), Vec3(-0.5, -0.35, 2.3)));
  sighting.stamp.reset();
  sighting.frame = "rig";
  sighting.child = "left";
  projection.add_sighting(sighting);
  projection.draw(100, 0, frame);
  const std::vector<FrameTree::Link> links = output.moving_frames(projection);
  ASSERT_EQ(links.size(), 2u);
  EXPECT_EQ(links[0].target, "procam/rig");
  EXPECT_EQ(links[0].source, "procam/surfaces/left");
  EXPECT_TRUE(links[0].target_from_source.pose.matrix().isApprox(sighting.frame_from_child.matrix(), 1e-9));
  EXPECT_EQ(links[1].source, "procam/surfaces/right");
  const auto place = [&](int i) {
    return place_of(projection.show().surfaces.surfaces[std::size_t(i)].geometry)->frame_from_surface;
  };
  const Pose beside = place(0).inverse() * place(1);
  EXPECT_TRUE(links[1].target_from_source.pose.matrix().isApprox(
      (sighting.frame_from_child * beside).matrix(), 1e-9));

  const test::Ros2Peer robot(domain);
  const dds_entity_t reader = robot.reader(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf");
  void* samples[1] = {};
  dds_sample_info_t info;
  int count = 0;
  for (int i = 0; i < 200 && count <= 0; ++i) {
    output.publish(projection, {});
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    count = dds_take(reader, samples, &info, 1, 1);
  }
  ASSERT_EQ(count, 1);
  const auto& received = *static_cast<const tf2_msgs_msg_dds__TFMessage_*>(samples[0]);
  ASSERT_EQ(received.transforms._length, 2u);
  EXPECT_STREQ(received.transforms._buffer[1].child_frame_id, "procam/surfaces/right");
  dds_return_loan(reader, samples, count);
}

}  // namespace
}  // namespace procam::show
