// A show in the ROS 2 graph as a user starts it: poses of /tf in, CameraInfo and static frames out, by real DDS traffic on
// the loopback interface. The robot is a DDS domain of this process.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "dds/ros2_peer.hpp"
#include "lamp_show.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/io/image/images.hpp"
#include "running_tool.hpp"

namespace procam::test {
namespace {

class Ros2Route : public LampShow {
 protected:
  void SetUp() override {
    SurfaceSet set;
    for (int i = 0; i < 4; ++i) set.surfaces.push_back(wall_around(i, "#ffffff"));
    save("surfaces.json", set);
  }
};

/// What publishes one transform as often as it is called.
class Sender {
 public:
  Sender(dds_entity_t writer, std::string frame, std::string child)
      : writer_(writer), frame_(std::move(frame)), child_(std::move(child)) {}
  void send(double stamp, double yaw, double x = 0) {
    geometry_msgs_msg_dds__TransformStamped_ one{};
    one.header.stamp = {std::int32_t(std::floor(stamp)), std::uint32_t(1e9 * (stamp - std::floor(stamp)))};
    one.header.frame_id = frame_.data();
    one.child_frame_id = child_.data();
    one.transform.translation = {x, 0, 0};
    one.transform.rotation = {0, 0, std::sin(yaw / 2), std::cos(yaw / 2)};
    tf2_msgs_msg_dds__TFMessage_ message{};
    message.transforms._buffer = &one;
    message.transforms._length = message.transforms._maximum = 1;
    EXPECT_EQ(dds_write(writer_, &message), DDS_RETCODE_OK);
  }

 private:
  dds_entity_t writer_;
  std::string frame_, child_;
};

TEST_F(Ros2Route, AShowFollowsTheRobotAndTellsTheGraphOfItsProjector) {
  const LoopbackDomain domain;
  const Ros2Peer robot(domain);
  Sender odom(robot.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf"), "odom", "base_link");
  Sender map(robot.writer(tf2_msgs_msg_dds__TFMessage__desc, "rt/tf_static", true, true), "map", "odom");
  map.send(0, 0.25);
  Running show("project-live",
               this->show() + "--control off --json --pose-source ros2:map,base_link --publish ros2:/procam" +
                   " --output frames:" + at("frames") + " --fps 20 --duration 3s --blank-on-stale 500ms",
               folder_ / "live.json");
  const double begin = steady_now();
  while (show.is_running() && steady_now() < begin + 20) {
    const double t = steady_now() - begin;
    odom.send(1.7e9 + t, 0.1 * std::sin(t), 0.05 * t);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  ASSERT_EQ(show.wait(), 0) << slurp(at("live.json.err"));
  const std::string said = slurp(at("live.json.err"));
  EXPECT_NE(said.find("ROS 2 domain " + std::to_string(domain.number()) + ", network lo (127.0.0.1)"),
            std::string::npos)
      << said;
  EXPECT_NE(said.find("publishes /procam/lamp/camera_info, /tf_static, /diagnostics"), std::string::npos)
      << said;
  const nlohmann::json live = nlohmann::json::parse(slurp(at("live.json")));
  EXPECT_GT(live["poses"]["taken"].get<double>(), 40) << live;
  EXPECT_EQ(live["poses"]["malformed"], 0);
  EXPECT_FALSE(live.contains("faults")) << live.dump();
  // The last frame is lit.
  const ImageU8 last = io::load_image(at("frames/frame_000050.png")).image;
  const std::uint8_t* end = last.data() + std::ptrdiff_t(last.width()) * last.height() * 3;
  EXPECT_TRUE(std::any_of(last.data(), end, [](std::uint8_t v) { return v > 0; }));
}

/// The environment's graph has no such robot: that is said, and the frames are dark.
TEST_F(Ros2Route, WithoutARobotTheReasonIsGiven) {
  const LoopbackDomain domain;
  const ToolRun run =
      run_tool("project-live", show() + "--control off --json --pose-source ros2: --output none " +
                                   "--fps 20 --duration 1500ms --blank-on-stale 500ms");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("no publisher of /tf was found in ROS domain " + std::to_string(domain.number())),
            std::string::npos)
      << run.err;
  EXPECT_EQ(run.json()["poses"]["taken"], 0);
  const ToolRun wrong = run_tool("project-live", show() + "--pose-source ros2:map --output none");
  EXPECT_EQ(wrong.exit_code, 3);
  EXPECT_NE(wrong.err.find("give two frames"), std::string::npos) << wrong.err;
}

}  // namespace
}  // namespace procam::test
