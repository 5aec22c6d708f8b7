// The blend of a group as a user starts it: hosts that come, end and are killed, by real DDS on the loopback interface.
#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <set>

#include "dds/ros2_peer.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "run_log.hpp"
#include "running_tool.hpp"
#include "show_page.hpp"
#include "support/udp.hpp"

namespace procam::test {
namespace {

using nlohmann::json;
using Names = std::vector<std::string>;

/// Three lopsided projectors in a row: "middle" overlaps both others, which do not overlap each other.
Rig row_of_projectors() {
  Rig rig;
  const auto add = [&](const std::string& name, double x, ImageSize size, const Intrinsics& lens) {
    RigProjector projector;
    projector.name = name;
    projector.projector.inverse_camera.intrinsics = lens;
    projector.projector.inverse_camera.size = size;
    projector.rig_from_projector = Pose(so3_exp(Vec3(0.02, -0.05 * x, 0.03)), Vec3(x, 0.04 * x, 0.1 * x));
    rig.projectors.push_back(projector);
  };
  add("left", -1.0, {320, 200}, {410.0, 396.0, 171.3, 88.9, 1.7});
  add("middle", 0.05, {300, 210}, {401.0, 405.0, 141.3, 102.4, -1.1});
  add("right", 1.0, {310, 190}, {415.0, 399.0, 151.3, 91.2, 0.6});
  return rig;
}

SurfaceSet wall_before_the_rig() {
  PlanarSurface wall;
  wall.frame = "rig";
  wall.frame_from_surface = Pose(so3_exp(Vec3(0.05, 0.04, -0.02)), Vec3(-2.2, -0.9, 2.1));
  wall.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  wall.points = {{0, 0}, {4.4, 0.02}, {4.38, 1.8}, {-0.03, 1.81}};
  SurfaceSet set;
  set.surfaces = {{"wall", wall, {}, "#ffffff"}};
  return set;
}

/// The sets of projectors that a run was blended for, each with the time of its first light.
struct BlendedRun {
  std::vector<std::pair<Names, double>> steps;
  int dark_frames = 0;
  explicit BlendedRun(const std::string& log) {
    show::RunReader reader(log);
    std::optional<Names> next;
    while (const auto record = reader.next()) {
      if (const auto* blend = std::get_if<show::BlendScene>(&*record)) next = blend->projectors;
      const auto* frame = std::get_if<show::RecordedFrame>(&*record);
      if (frame == nullptr) continue;
      if (next && (steps.empty() || steps.back().first != *next))
        steps.emplace_back(*next, frame->light_time);
      next.reset();
      dark_frames += !steps.empty() && steps.back().first.empty() ? 1 : 0;
    }
  }
  /// Of the first frame that was blended for exactly these; NaN: none.
  double begin(const Names& names) const {
    for (const auto& [set, time] : steps)
      if (set == names) return time;
    return std::nan("");
  }
};

class BlendRoute : public testing::Test {
 protected:
  BlendRoute() {
    io::save_rig(at("rig.json"), row_of_projectors());
    io::save_surfaces(at("surfaces.json"), wall_before_the_rig());
  }
  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  std::string show() const { return "--rig " + at("rig.json") + " --surfaces " + at("surfaces.json") + " "; }
  std::string host(const std::string& projector, const Page& page, int strength) const {
    return show() + "--projector " + projector + " --json --group stage --group-strength " +
           std::to_string(strength) + " --output none --fps 25 --record " + at(projector + ".log") +
           page.flags();
  }
  static json blended(const Page& page) {
    const json status = page.status();
    return status.is_object() && status["blend"].is_object() && status["blend"]["dark"] == false
               ? status["blend"]["projectors"]
               : json();
  }
  ScratchFolder folder_;
};

TEST_F(BlendRoute, HostsOfAGroupBlendAndNeighboursOfAKilledOneFillItsPlaceWithinASecond) {
  const LoopbackDomain domain;
  const Page of_left(free_udp_port()), of_middle(free_udp_port()), of_right(free_udp_port());
  Running left("project-live", host("left", of_left, 9), folder_ / "left.out");
  ASSERT_TRUE(becomes_true([&] { return blended(of_left) == json{"left"}; })) << slurp(at("left.out.err"));
  Running middle("project-live", host("middle", of_middle, 5), folder_ / "middle.out");
  ASSERT_TRUE(becomes_true([&] {
    return blended(of_middle) == json{"left", "middle"};
  })) << slurp(at("middle.out.err"));
  Running right("project-live", host("right", of_right, 1), folder_ / "right.out");
  for (const Page* page : {&of_left, &of_middle, &of_right})
    ASSERT_TRUE(becomes_true([&] {
      return blended(*page) == json{"left", "middle", "right"};
    })) << slurp(at("right.out.err"));
  EXPECT_NE(of_left.metrics().find("procam_blend_projector{projector=\"middle\"} 1"), std::string::npos);
  std::this_thread::sleep_for(std::chrono::milliseconds(1200));  // logs are written each second

  middle.tell(SIGKILL);
  const double killed = steady_now();
  for (const Page* page : {&of_left, &of_right})
    EXPECT_TRUE(becomes_true([&] { return blended(*page) == json{"left", "right"}; }));
  right.tell(SIGTERM);
  right.wait();
  const double ended = steady_now();
  EXPECT_TRUE(becomes_true([&] { return blended(of_left) == json{"left"}; }));
  left.tell(SIGTERM);
  left.wait();

  const BlendedRun by_left(at("left.log")), by_middle(at("middle.log")), by_right(at("right.log"));
  for (const BlendedRun* run : {&by_left, &by_right}) {
    const double filled = run->begin({"left", "right"}) - killed;
    EXPECT_GT(filled, 0.3);
    EXPECT_LT(filled, 1.0);
    RecordProperty(run == &by_left ? "left_ms" : "right_ms", int(1e3 * filled));
  }
  ASSERT_EQ(by_left.steps.back().first, Names{"left"});
  EXPECT_LT(by_left.steps.back().second - ended, 0.3) << "one that ends says so";
  RecordProperty("ended_ms", int(1e3 * (by_left.steps.back().second - ended)));
  // A host that comes is dark until the others are ready, and all change in one frame.
  ASSERT_EQ(by_middle.steps.front().first, Names{});
  EXPECT_GT(by_middle.dark_frames, 20);
  EXPECT_EQ(by_middle.steps.at(1).first, (Names{"left", "middle"})) << "never unblended";
  EXPECT_NEAR(by_middle.begin({"left", "middle"}), by_left.begin({"left", "middle"}), 0.1);
  EXPECT_NEAR(by_right.begin({"left", "middle", "right"}), by_left.begin({"left", "middle", "right"}), 0.1);
  RecordProperty("together_ms",
                 int(1e3 * (by_middle.begin({"left", "middle"}) - by_left.begin({"left", "middle"}))));
  for (const std::string projector : {"left", "right"}) {
    const ToolRun again =
        run_tool("project-live", show() + "--projector " + projector + " --control off --json --replay " +
                                     at(projector + ".log") + " --output none");
    EXPECT_EQ(again.exit_code, 0) << again.err << again.out;
    EXPECT_GT(again.json()["equal"].get<double>(), 20);
  }
}

/// A host with two projectors and one with the third show what one process with all three shows, bit for bit. When the first
/// host dies, both of its projectors are gone at once.
TEST_F(BlendRoute, AHostWithTwoProjectorsIsOneMember) {
  const LoopbackDomain domain;
  const auto screens = [&](const std::string& to, const std::vector<std::string>& names) {
    std::string flags;
    for (const std::string& name : names) flags += " --screen " + name + "=frames:" + at(to + "_" + name);
    return flags;
  };
  const auto last_frame = [&](const std::string& of) {
    std::set<std::filesystem::path> files;
    for (const auto& file : std::filesystem::directory_iterator(folder_ / of)) files.insert(file.path());
    EXPECT_FALSE(files.empty()) << of;
    const ImageU8 frame = files.empty() ? ImageU8() : io::load_image(*files.rbegin()).image;
    const auto* begin = frame.data();
    return std::vector<std::uint8_t>(
        begin, begin + std::ptrdiff_t(frame.width()) * frame.height() * frame.channels());
  };
  const ToolRun alone = run_tool("project-live", show() + "--json --control off --fps 5 --duration 2s" +
                                                     screens("alone", {"left", "middle", "right"}));
  ASSERT_EQ(alone.exit_code, 0) << alone.err;

  const Page of_two(free_udp_port()), of_one(free_udp_port());
  Running two("project-live",
              show() + "--json --group stage --group-strength 9 --fps 5" +
                  screens("two", {"left", "middle"}) + of_two.flags(),
              folder_ / "two.out");
  ASSERT_TRUE(becomes_true([&] {
    return blended(of_two) == json{"left", "middle"};
  })) << slurp(at("two.out.err"));
  Running one("project-live",
              show() + "--projector right --json --group stage --fps 5 --output frames:" + at("one_right") +
                  of_one.flags(),
              folder_ / "one.out");
  for (const Page* page : {&of_two, &of_one})
    ASSERT_TRUE(becomes_true([&] {
      return blended(*page) == json{"left", "middle", "right"};
    })) << slurp(at("one.out.err"));
  EXPECT_EQ(of_one.metric("procam_group_hosts"), 2);
  std::this_thread::sleep_for(std::chrono::milliseconds(600));
  two.tell(SIGKILL);
  const double killed = steady_now();
  const std::vector<std::uint8_t> third = last_frame("one_right");
  EXPECT_TRUE(becomes_true([&] { return blended(of_one) == json{"right"}; }));
  EXPECT_LT(steady_now() - killed, 1.2);
  EXPECT_TRUE(third == last_frame("alone_right"));
  EXPECT_FALSE(last_frame("one_right") == third) << "it lights the place of the others, too";
  for (const std::string name : {"left", "middle"})
    EXPECT_TRUE(last_frame("two_" + name) == last_frame("alone_" + name)) << name;
}

TEST_F(BlendRoute, WhatCannotBeBlendedIsRefused) {
  const std::string line = show() + "--projector left --control off --output none --duration 200ms ";
  EXPECT_EQ(run_tool("project-live", line + "--blend middle --black left=0.001").exit_code, 0);
  const ToolRun unknown = run_tool("project-live", line + "--blend centre");
  EXPECT_EQ(unknown.exit_code, 3);
  EXPECT_NE(unknown.err.find("name one of: left, middle, right"), std::string::npos) << unknown.err;
  const ToolRun in_group = run_tool("project-live", line + "--blend middle --group stage");
  EXPECT_EQ(in_group.exit_code, 3);
  EXPECT_NE(in_group.err.find("announce their projectors"), std::string::npos) << in_group.err;
  SurfaceSet set = wall_before_the_rig();
  place_of(set.surfaces[0].geometry)->frame = "world";
  io::save_surfaces(at("surfaces.json"), set);
  const ToolRun moving = run_tool("project-live", line + "--blend middle --pose-source udp:0");
  EXPECT_EQ(moving.exit_code, 3);
  EXPECT_NE(moving.err.find("the rig moves"), std::string::npos) << moving.err;
  const ToolRun black = run_tool("project-live", line + "--blend middle --black left=2");
  EXPECT_EQ(black.exit_code, 3) << black.err;
}

}  // namespace
}  // namespace procam::test
