// Robots of a fleet as a user starts them: processes that talk by real DDS on the loopback interface.
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <set>

#include "dds/ros2_peer.hpp"
#include "lamp_show.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/pose_file.hpp"
#include "running_tool.hpp"
#include "show_page.hpp"
#include "support/udp.hpp"

namespace procam::test {
namespace {

class RobotFleetRoute : public LampShow {
 protected:
  void SetUp() override {
    SurfaceSet set;
    set.surfaces = {lamp_sign("sign", "#00ff00")};
    save("surfaces.json", set);
  }
  std::string flags(const std::string& robot, const Page& page, const std::string& more) const {
    return show() + "--json --fleet hall --robot " + robot + " --output frames:" + at(robot) + " --fps 20 " +
           more + page.flags();
  }
  static bool lights(const Page& page, const std::string& robot) {
    return page.metrics().find("procam_fleet_surface{surface=\"sign\",robot=\"" + robot + "\"} 1") !=
           std::string::npos;
  }
};

TEST_F(RobotFleetRoute, ASurfaceIsLitByOneRobotHandedOverAndTakenBackWhenThatOneIsKilled) {
  const LoopbackDomain domain;
  const Page of_rover(free_udp_port()), of_spot(free_udp_port());
  Running rover("project-live", flags("rover", of_rover, "--priority 1"), folder_ / "rover.out");
  ASSERT_TRUE(becomes_true([&] { return of_rover.metric("procam_fleet_lit") == 1; }))
      << slurp(at("rover.out.err"));
  Running spot("project-live", flags("spot", of_spot, "--priority 5"), folder_ / "spot.out");
  ASSERT_TRUE(becomes_true([&] { return of_spot.metric("procam_fleet_lit") == 1; }))
      << slurp(at("spot.out.err"));
  EXPECT_TRUE(becomes_true([&] { return lights(of_rover, "spot"); }));
  EXPECT_EQ(of_rover.metric("procam_fleet_lit"), 0);
  EXPECT_FALSE(lights(of_rover, "rover"));
  EXPECT_EQ(of_rover.metric("procam_fleet_robots"), 2);

  spot.tell(SIGKILL);
  const double killed = steady_now();
  EXPECT_TRUE(becomes_true([&] { return of_rover.metric("procam_fleet_lit") == 1; }));
  const double takeover = steady_now() - killed;  // with the page's 0.1 s
  EXPECT_LT(takeover, 1.2);
  RecordProperty("takeover_ms", int(1e3 * takeover));
  rover.tell(SIGTERM);
  rover.wait();
  const std::string words = slurp(at("rover.out.err"));
  EXPECT_NE(words.find("fleet hall: spot lights 'sign'"), std::string::npos) << words;

  // The frames themselves: dark, lit, dark while the other robot has it, lit.
  std::string changes;
  std::set<std::filesystem::path> files;
  for (const auto& file : std::filesystem::directory_iterator(folder_ / "rover")) files.insert(file.path());
  for (const auto& file : files) {
    const ImageU8 frame = io::load_image(file).image;
    const std::uint8_t* const begin = frame.data();
    const bool is_lit =
        std::any_of(begin, begin + std::ptrdiff_t(frame.width()) * frame.height() * frame.channels(),
                    [](std::uint8_t value) { return value > 0; });
    if (changes.empty() || (changes.back() == 'l') != is_lit) changes += is_lit ? 'l' : 'd';
  }
  EXPECT_EQ(changes, "dldl");
}

/// Two robots before the ends of one long wall: each lights its end, since their light does not meet. A third one that stands
/// between them waits: it would light what they light.
TEST_F(RobotFleetRoute, RobotsWhoseLightIsApartLightOneWallTogether) {
  const LoopbackDomain domain;
  PlanarSurface wall;
  wall.frame_from_surface = Pose(looks_ahead(), Vec3(2.3, 4.0, 1.9));
  wall.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  wall.points = {{0, 0}, {8, 0.02}, {8, 1.8}, {-0.03, 1.81}};
  SurfaceSet set;
  set.surfaces = {{"sign", wall, {}, "#00ff00"}};
  save("surfaces.json", set);
  const auto standing_at = [&](const std::string& robot, double y) {
    io::save_pose(at(robot + "_pose.json"),
                  {"world", "rig", {Pose(so3_exp(Vec3(0, 0, 0.02)), Vec3(0.1, y, 0)), Mat6::Zero()}});
    return "--pose " + at(robot + "_pose.json") + " ";
  };
  const Page of_rover(free_udp_port()), of_spot(free_udp_port()), of_late(free_udp_port());
  Running rover("project-live", flags("rover", of_rover, standing_at("rover", 2.2)), folder_ / "rover.out");
  ASSERT_TRUE(becomes_true([&] { return of_rover.metric("procam_fleet_lit") == 1; }))
      << slurp(at("rover.out.err"));
  Running spot("project-live", flags("spot", of_spot, standing_at("spot", -2.1) + "--priority 5 "),
               folder_ / "spot.out");
  ASSERT_TRUE(becomes_true([&] {
    return of_rover.metric("procam_fleet_lit") == 1 && of_spot.metric("procam_fleet_lit") == 1 &&
           lights(of_rover, "spot") && lights(of_rover, "rover");
  })) << slurp(at("spot.out.err"));
  Running late("project-live", flags("late", of_late, standing_at("late", 1.5)), folder_ / "late.out");
  ASSERT_TRUE(becomes_true([&] { return of_late.metric("procam_fleet_robots") == 3; }));
  std::this_thread::sleep_for(std::chrono::seconds(4));
  EXPECT_EQ(of_late.metric("procam_fleet_lit"), 0) << "it would light what the rover lights";
  EXPECT_EQ(of_rover.metric("procam_fleet_lit"), 1);
  EXPECT_EQ(of_spot.metric("procam_fleet_lit"), 1);
}

TEST_F(RobotFleetRoute, WhatAFleetCannotBeIsRefused) {
  const auto refused = [&](const std::string& more, int code, const std::string& words) {
    const ToolRun run = run_tool("project-live", show() + more + " --control off --output none");
    EXPECT_EQ(run.exit_code, code) << run.err;
    EXPECT_NE(run.err.find(words), std::string::npos) << run.err;
  };
  refused("--fleet hall --robot a/b", 3, "robot 'a/b'");
  refused("--fleet hall --robot spot --group stage", 3, "leave out --fleet or --group");
  refused("--fleet hall --robot spot --fleet-blend --watch camera:0", 3,
          "leave out --watch or --fleet-blend");
  refused("--fleet hall --robot spot --record " + at("run.log"), 3, "leave one of them out");
  refused("--fleet hall", 2, "--robot");
  refused("--priority 3", 2, "--fleet");
}

}  // namespace
}  // namespace procam::test
