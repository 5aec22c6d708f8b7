// One show on several hosts as a user starts it: processes that talk by real DDS on the loopback interface.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "dds/ros2_peer.hpp"
#include "lamp_show.hpp"
#include "procam/core/base/clock.hpp"
#include "run_log.hpp"
#include "running_tool.hpp"
#include "show_page.hpp"
#include "support/udp.hpp"

namespace procam::test {
namespace {

using nlohmann::json;

/// A recorded run.
struct RecordedRun {
  std::vector<show::RecordedFrame> frames;
  std::vector<track::StampedPose> poses;
  explicit RecordedRun(const std::string& log) {
    show::RunReader reader(log);
    while (const auto record = reader.next()) {
      if (const auto* frame = std::get_if<show::RecordedFrame>(&*record)) frames.push_back(*frame);
      if (const auto* pose = std::get_if<track::StampedPose>(&*record)) poses.push_back(*pose);
    }
  }
};

class GroupRoute : public LampShow {
 protected:
  /// Three hosts: their files of surfaces differ.
  void SetUp() override {
    for (const char* const host : {"a", "b", "c"}) {
      SurfaceSet set;
      set.surfaces = {lamp_sign("sign", "#00ff00"), wall_around(0, "#ffffff")};
      if (host[0] != 'a') set.surfaces[0].name = std::string("sign of ") + host;
      save(host + std::string(".json"), set);
    }
  }
  std::string flags(const std::string& host, const Page& page, int strength) const {
    return show(host + ".json") + "--json --group stage --group-strength " + std::to_string(strength) +
           " --output none --fps 25 --record " + at(host + ".log") + page.flags();
  }
  std::string corner(const Page& page) const {
    const json status = page.status();
    if (!status.is_object() || status["surfaces"].empty()) return "";
    return status["surfaces"][0]["name"].get<std::string>() + " " + status["surfaces"][0]["points"][2].dump();
  }
};

TEST_F(GroupRoute, AnEditAnywhereIsShownEverywhereAndAKilledLeaderIsReplacedWithoutAJump) {
  const LoopbackDomain domain;
  const std::string poses = free_udp_port();
  const Page page_a(free_udp_port()), page_b(free_udp_port()), page_c(free_udp_port());
  Running a("project-live", flags("a", page_a, 9), folder_ / "a.out");
  ASSERT_TRUE(becomes_true([&] { return page_a.metric("procam_group_leads") == 1; }))
      << slurp(at("a.out.err"));
  Running b("project-live", flags("b", page_b, 5), folder_ / "b.out");
  // Only the third host has poses, and it is no leader.
  Running c("project-live", flags("c", page_c, 1) + " --pose-source udp:127.0.0.1:" + poses,
            folder_ / "c.out");
  for (const Page* page : {&page_a, &page_b, &page_c})
    ASSERT_TRUE(becomes_true([&] { return page->metric("procam_group_hosts") == 3; }))
        << slurp(at("b.out.err")) << slurp(at("c.out.err"));
  EXPECT_EQ(corner(page_b).substr(0, 5), "sign ") << "the leader's surfaces";
  Running robot("simulate-robot",
                "--path circle:0.8m --speed 0.5m/s --rate 60 --noise 3mm,0.2deg --duration 60s --seed 3 --to "
                "udp:127.0.0.1:" +
                    poses,
                folder_ / "robot.out");
  EXPECT_TRUE(becomes_true([&] { return page_b.status()["pose_state"] == "fresh"; }));

  page_c.command({{"do", "move"}, {"surface", "sign"}, {"point", 2}, {"pixels", {100.5, 144.25}}});
  for (const Page* page : {&page_a, &page_b, &page_c})
    EXPECT_TRUE(becomes_true([&] { return corner(*page) == "sign [100.5,144.25]"; })) << corner(*page);

  a.tell(SIGKILL);
  const double killed = steady_now();
  EXPECT_TRUE(becomes_true([&] { return page_b.metric("procam_group_leads") == 1; }));
  const double takeover = steady_now() - killed;  // with the page's 0.1 s
  EXPECT_LT(takeover, 1.2);
  RecordProperty("takeover_ms", int(1e3 * takeover));
  EXPECT_EQ(corner(page_b), "sign [100.5,144.25]") << "the last state goes on";
  page_c.command({{"do", "nudge"}, {"surface", "sign"}, {"point", 2}, {"pixels", {1, 0}}});
  EXPECT_TRUE(becomes_true([&] { return corner(page_b) == "sign [101.5,144.25]"; })) << corner(page_b);
  // Saved where it is asked and everywhere else.
  page_b.command({{"do", "save"}});
  EXPECT_TRUE(becomes_true([&] {
    const std::string text = slurp(at("c.json"));
    return text.find("101.5") != text.npos && slurp(at("b.json")).find("101.5") != text.npos;
  }));
  page_c.command({{"do", "move"}, {"surface", "nothing"}, {"point", 0}, {"pixels", {1, 1}}});
  page_b.command({{"do", "freeze"}});
  EXPECT_TRUE(becomes_true([&] { return page_c.status()["frozen"] == true; }));
  b.tell(SIGTERM);
  c.tell(SIGTERM);
  b.wait();
  c.wait();
  EXPECT_NE(slurp(at("c.out.err")).find("leads, one clock with the leader"), std::string::npos);

  // One clock of contents for all, before and after the takeover: digit by digit, on one machine.
  const RecordedRun of_b(at("b.log")), of_c(at("c.log"));
  ASSERT_GT(of_b.frames.size(), 20u);
  ASSERT_GT(of_c.frames.size(), 20u);
  const double epoch = of_b.frames.front().light_time - of_b.frames.front().content_time;
  for (const RecordedRun* run : {&of_b, &of_c})
    for (std::size_t i = 0; i + 1 < run->frames.size(); ++i)  // the last one is frozen
      ASSERT_NEAR(run->frames[i].light_time - run->frames[i].content_time, epoch, 1e-7) << i;
  EXPECT_EQ(of_b.frames.back().content_time, of_c.frames.back().content_time) << "of one moment";
  // The poses of the third host.
  std::set<std::pair<double, double>> known;
  for (const track::StampedPose& pose : of_c.poses) known.insert({*pose.stamp, pose.arrival});
  EXPECT_GT(of_b.poses.size(), 20u);
  for (const track::StampedPose& pose : of_b.poses)
    EXPECT_EQ(known.count({*pose.stamp, pose.arrival}), 1u) << *pose.stamp;
  // A host alone, with the same input, draws the same frames bit for bit.
  for (const std::string host : {"b", "c"}) {
    const ToolRun again = run_tool("project-live", show(host + ".json") + "--control off --json --replay " +
                                                       at(host + ".log") + " --output none");
    EXPECT_EQ(again.exit_code, 0) << again.err << again.out;
    EXPECT_GT(again.json()["equal"].get<double>(), 20);
  }
}

TEST_F(GroupRoute, WhatAGroupCannotShareIsRefused) {
  const ToolRun name = run_tool("project-live", show("a.json") + "--group a/b --control off --output none");
  EXPECT_EQ(name.exit_code, 3) << name.err;
  EXPECT_NE(name.err.find("group 'a/b'"), std::string::npos) << name.err;
  const ToolRun watched =
      run_tool("project-live", show("a.json") + "--group stage --watch camera:0 --control off --output none");
  EXPECT_EQ(watched.exit_code, 3) << watched.err;
  EXPECT_NE(watched.err.find("leave out --watch or --group"), std::string::npos) << watched.err;
  const ToolRun strength = run_tool("project-live", show("a.json") + "--group-strength 5 --control off");
  EXPECT_NE(strength.exit_code, 0);
  EXPECT_NE(strength.err.find("--group"), std::string::npos) << strength.err;
}

}  // namespace
}  // namespace procam::test
