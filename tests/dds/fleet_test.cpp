// Robots of a fleet by real DDS traffic on the loopback interface: a process that is killed, else participants.
#include "procam/dds/fleet.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <limits>
#include <mutex>
#include <thread>

#include "fleet_limits.hpp"
#include "fleet_messages.h"
#include "graph_values.hpp"
#include "member_process.hpp"
#include "procam/core/base/clock.hpp"
#include "ros2_peer.hpp"
#include "support/expect_error.hpp"

namespace procam::dds {
namespace {

using test::LoopbackDomain;
using test::wait_until;
using Names = std::vector<std::string>;

/// A show that draws a frame each 5 ms, on the wall after 10 ms.
class Show {
 public:
  Show(const std::string& robot, FleetClaim claim) : fleet({"hall", robot, 0.015}), claim_(std::move(claim)) {
    thread_ = std::thread([this] { run(); });
  }
  ~Show() {
    ends_ = true;
    thread_.join();
  }
  void set(FleetClaim claim) {
    const std::lock_guard<std::mutex> lock(mutex_);
    claim_ = std::move(claim);
  }
  /// The times at which the light on its surface changed, from dark.
  std::vector<double> changes() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return changes_;
  }
  bool is_lit() const { return changes().size() % 2 == 1; }

  RobotFleet fleet;

 private:
  void run() {
    while (!ends_) {
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        fleet.claim({claim_});
      }
      const Names lit = fleet.lit();
      const double light_time = steady_now() + 0.01;
      fleet.shown(lit, light_time);
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (lit.empty() == (changes_.size() % 2 == 1)) changes_.push_back(light_time);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
  FleetClaim claim_;
  mutable std::mutex mutex_;
  std::vector<double> changes_;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

FleetClaim wall(int priority, bool ready = true, bool blend = false) {
  return {"wall", priority, blend, ready, {{0.1, 0}, {2.5, 0.2}, {2.2, 1.5}, {0, 1.1}}};
}

TEST(RobotFleet, WhenTheRobotThatLightsIsKilledAnotherLightsWithinASecond) {
  const LoopbackDomain domain;
  test::MemberProcess spot([] {
    Show show("spot", wall(9));
    std::this_thread::sleep_for(std::chrono::hours(1));
  });
  Show rover("rover", wall(1)), zed("zed", wall(1));
  ASSERT_TRUE(wait_until([&] { return rover.fleet.status().by["wall"] == Names{"spot"}; }));
  ASSERT_TRUE(wait_until([&] { return zed.fleet.status().by["wall"] == Names{"spot"}; }));
  EXPECT_EQ(rover.fleet.status().robots, 3);
  EXPECT_EQ(rover.fleet.status().largest_latency, 0.015);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  const bool was_dark = rover.changes().size() % 2 == 0 && zed.changes().size() % 2 == 0;
  EXPECT_TRUE(was_dark);
  spot.end();
  const double killed = steady_now();
  ASSERT_TRUE(wait_until([&] { return rover.is_lit(); }));
  const double dark = rover.changes().back() - killed;
  EXPECT_LT(dark, 1);
  RecordProperty("dark_ms", int(1e3 * dark));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_TRUE(rover.is_lit());
  EXPECT_FALSE(zed.is_lit()) << "of equal ones, one";
  EXPECT_TRUE(wait_until([&] { return zed.fleet.status().by["wall"] == Names{"rover"}; }));
  EXPECT_EQ(zed.fleet.status().robots, 2);
}

TEST(RobotFleet, LightIsHandedOverWhenTheNextRobotIsReadyAndNeverTwice) {
  const LoopbackDomain domain;
  Show rover("rover", wall(1)), third("third", wall(-7));
  ASSERT_TRUE(wait_until([&] { return rover.is_lit(); }));
  Show spot("spot", wall(9, false));
  ASSERT_TRUE(wait_until([&] { return spot.fleet.status().by["wall"] == Names{"rover"}; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  EXPECT_TRUE(rover.is_lit()) << "until the other is ready";
  const double ready = steady_now();
  spot.set(wall(9));
  ASSERT_TRUE(wait_until([&] { return spot.is_lit(); }));
  const double begin = spot.changes().back(), end = rover.changes().back();
  EXPECT_GE(begin, end) << "never two";
  EXPECT_LT(begin - end, 0.1);
  EXPECT_LT(begin - ready, 0.3);
  RecordProperty("dark_us", int(1e6 * (begin - end)));
  RecordProperty("hand_over_ms", int(1e3 * (begin - ready)));
  EXPECT_TRUE(third.changes().empty());
  // And back.
  spot.set(wall(0));
  ASSERT_TRUE(wait_until([&] { return rover.is_lit(); }));
  EXPECT_GE(rover.changes().back(), spot.changes().back());
}

TEST(RobotFleet, BothLightWhereBothBlend) {
  const LoopbackDomain domain;
  Show rover("rover", wall(1, true, true)), spot("spot", wall(5, true, true));
  EXPECT_TRUE(wait_until([&] { return rover.is_lit() && spot.is_lit(); }));
  EXPECT_TRUE(wait_until([&] { return rover.fleet.status().by["wall"] == Names{"rover", "spot"}; }));
  EXPECT_EQ(rover.changes().size(), 1u);
}

TEST(RobotFleet, ARobotThatEndsIsReplacedAtOnce) {
  const LoopbackDomain domain;
  auto spot = std::make_unique<Show>("spot", wall(9));
  Show rover("rover", wall(1));
  ASSERT_TRUE(wait_until([&] { return rover.fleet.status().by["wall"] == Names{"spot"}; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(1200));
  const double ended = steady_now();
  spot.reset();
  ASSERT_TRUE(wait_until([&] { return rover.is_lit(); }));
  EXPECT_LT(rover.changes().back() - ended, 0.3);
}

/// Writes what a robot would, in another process as far as DDS is concerned.
class Stranger {
 public:
  explicit Stranger(const LoopbackDomain& domain) : peer_(domain) {
    dds_qos_t* const qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
    dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_liveliness(qos, DDS_LIVELINESS_AUTOMATIC, DDS_MSECS(400));
    const dds_entity_t topic = dds_create_topic(peer_.participant(), &procam_fleet_Announcement_desc,
                                                "procam/fleet/hall/robot", nullptr, nullptr);
    writer_ = dds_create_writer(peer_.participant(), topic, qos, nullptr);
    dds_delete_qos(qos);
    EXPECT_GT(writer_, 0);
    corners_ = {{0, 0}, {1, 0}, {1, 1}};
    claim_.surface = surface_.data();
    claim_.ready = claim_.lights = true;
    claim_.turn = 1;
    claim_.priority = 500;
    message.robot = robot_.data();
    message.fleet = fleet_.data();
    set(corners_.size());
    message.claims._buffer = &claim_;
    message.claims._length = message.claims._maximum = 1;
  }
  void set(std::size_t corners) {
    corners_.resize(corners, {1, 1});
    claim_.region._buffer = corners_.data();
    claim_.region._length = claim_.region._maximum = std::uint32_t(corners);
  }
  void write() {
    ++message.sequence_number;
    EXPECT_EQ(dds_write(writer_, &message), DDS_RETCODE_OK);
  }
  procam_fleet_Announcement message{};
  procam_fleet_Claim& claim() { return claim_; }

 private:
  test::Ros2Peer peer_;
  dds_entity_t writer_ = 0;
  std::string robot_ = "stranger", fleet_ = "hall", surface_ = "wall";
  std::vector<procam_fleet_Corner> corners_;
  procam_fleet_Claim claim_{};
};

TEST(RobotFleet, InvalidAnnouncementsAreCountedAndChangeNothing) {
  const LoopbackDomain domain;
  Show rover("rover", wall(1));
  ASSERT_TRUE(wait_until([&] { return rover.is_lit(); }));
  Stranger stranger(domain);
  std::uint64_t rejected = 0;
  std::string other = "hall2";
  const std::string good_fleet = "hall";
  const std::pair<const char*, std::function<void(Stranger&)>> faults[] = {
      {"latency", [](Stranger& s) { s.message.latency = std::numeric_limits<double>::quiet_NaN(); }},
      {"corners",
       [](Stranger& s) {
         s.message.latency = 0;
         s.set(limits::kFleetRegionCorners + 1);
       }},
      {"fleet",
       [&](Stranger& s) {
         s.set(3);
         s.message.fleet = other.data();
       }},
      {"turn",
       [&](Stranger& s) {
         other = good_fleet;
         s.message.fleet = other.data();
         s.claim().turn = 0;
       }},
      {"priority", [](Stranger& s) {
         s.claim().turn = 1;
         s.claim().priority = 1001;
       }}};
  for (const auto& [name, spoil] : faults) {
    spoil(stranger);
    ASSERT_TRUE(wait_until([&] {
      stranger.write();
      return rover.fleet.status().rejected > rejected;
    })) << name;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    rejected = rover.fleet.status().rejected;
    EXPECT_EQ(rover.fleet.status().robots, 1) << name;
  }
  EXPECT_EQ(rover.changes().size(), 1u) << "it stayed lit";
  // And a valid one counts.
  stranger.claim().priority = 500;
  stranger.write();
  EXPECT_TRUE(wait_until([&] { return rover.fleet.status().robots == 2 && !rover.is_lit(); }));
}

TEST(RobotFleet, OptionsAndClaimsThatCannotBeAreRefused) {
  EXPECT_ERROR(RobotFleet({"a/b", "spot"}), kInput, "fleet 'a/b'");
  EXPECT_ERROR(RobotFleet({"hall", ""}), kInput, "robot ''");
  EXPECT_ERROR(RobotFleet({"hall", "spot", -1}), kInput, "latency");
  const LoopbackDomain domain;
  RobotFleet fleet({"hall", "spot"});
  EXPECT_ERROR(fleet.claim({wall(2000)}), kInput, "a priority is not from -1000 to 1000");
}

}  // namespace
}  // namespace procam::dds
