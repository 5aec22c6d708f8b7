// Which robot of a fleet lights which surface, and hand-over: without DDS, in a time of its own.
#include "fleet_turns.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <set>

#include "fleet_checks.hpp"

namespace procam::dds::internal {
namespace {

using Names = std::vector<std::string>;

/// A convex quadrilateral on the surface, lopsided.
Points2 quad(double left, double top, double width, double height) {
  return {{left, top},
          {left + width, top + 0.05 * height},
          {left + 0.9 * width, top + height},
          {left + 0.1 * width, top + 0.8 * height}};
}

FleetAnnouncement announcement(const std::string& robot, FleetClaim claim, bool lights = false) {
  FleetAnnouncement one;
  one.robot = robot;
  one.claims.push_back({std::move(claim), lights ? 1u : 0u, lights});
  return one;
}

FleetClaim claim(int priority, bool blend = false, Points2 region = {}) {
  return {"wall", priority, blend, true, std::move(region)};
}

TEST(FleetDecision, TheGreatestPriorityLightsAndOfEqualOnesTheOneThatLightsThenTheLesserName) {
  EXPECT_EQ(fleet_decision({announcement("a", claim(1)), announcement("b", claim(2))})["wall"], Names{"b"});
  EXPECT_EQ(fleet_decision({announcement("b", claim(2)), announcement("a", claim(2))})["wall"], Names{"a"});
  EXPECT_EQ(fleet_decision({announcement("a", claim(2)), announcement("b", claim(2), true)})["wall"],
            Names{"b"})
      << "equal robots do not alternate";
  EXPECT_EQ(fleet_decision({announcement("a", claim(3)), announcement("b", claim(2), true)})["wall"],
            Names{"a"});
}

TEST(FleetDecision, ARobotThatIsNotReadyLightsNothing) {
  FleetClaim late = claim(9);
  late.ready = false;
  EXPECT_EQ(fleet_decision({announcement("a", late), announcement("b", claim(-5))})["wall"], Names{"b"});
  EXPECT_TRUE(fleet_decision({announcement("a", late)}).empty());
}

TEST(FleetDecision, BothLightWhereBothBlendAndWhereTheirRegionsAreApart) {
  const auto both = [](const FleetClaim& a, const FleetClaim& b) {
    return fleet_decision({announcement("a", a), announcement("b", b)})["wall"].size() == 2;
  };
  EXPECT_TRUE(both(claim(1, true), claim(2, true)));
  EXPECT_FALSE(both(claim(1, true), claim(2, false)));
  EXPECT_FALSE(both(claim(1), claim(1)));
  EXPECT_TRUE(both(claim(1, false, quad(0, 0, 1, 1)), claim(1, false, quad(1.01, 0.3, 2, 1))));
  EXPECT_FALSE(both(claim(1, false, quad(0, 0, 1, 1)), claim(1, false, quad(0.9, -0.3, 2, 1))));
  EXPECT_FALSE(both(claim(1), claim(1, false, quad(5, 5, 1, 1)))) << "no region: all of the surface";
  FleetClaim other = claim(1);
  other.surface = "floor";
  EXPECT_EQ(fleet_decision({announcement("a", claim(1)), announcement("b", other)}).size(), 2u);
}

TEST(FleetDecision, AThirdRobotWithoutBlendDoesNotPartTwoThatBlendBeforeIt) {
  auto decision = fleet_decision({announcement("a", claim(3, true)), announcement("b", claim(2, true)),
                                  announcement("c", claim(1, false))});
  EXPECT_EQ(decision["wall"], (Names{"a", "b"}));
  decision = fleet_decision({announcement("a", claim(3, true)), announcement("b", claim(2, true)),
                             announcement("c", claim(9, false))});
  EXPECT_EQ(decision["wall"], Names{"c"});
}

/// 3000 random fleets: the same decision in each order of the announcements; every ready robot lights or is in conflict with
/// one that does; no two in conflict light.
TEST(FleetDecision, IsOneForAllRobotsAndLightsEachPlaceOnce) {
  std::mt19937_64 random(11);
  const auto pick = [&](int n) { return int(random() % std::uint64_t(n)); };
  for (int trial = 0; trial < 3000; ++trial) {
    std::vector<FleetAnnouncement> all;
    for (int r = 0, n = 1 + pick(5); r < n; ++r) {
      FleetClaim one = claim(pick(3), pick(2) == 0);
      one.ready = pick(4) != 0;
      if (pick(2) == 0) one.region = quad(0.1 * pick(30), 0.1 * pick(10), 0.3 + 0.1 * pick(10), 0.7);
      all.push_back(announcement("robot" + std::to_string(r), one, pick(2) == 0));
    }
    const auto decision = fleet_decision(all);
    std::shuffle(all.begin(), all.end(), random);
    ASSERT_EQ(fleet_decision(all), decision) << trial;
    const auto found = decision.find("wall");
    const Names lit = found == decision.end() ? Names() : found->second;
    for (const FleetAnnouncement& one : all) {
      const FleetClaim& own = one.claims[0].claim;
      int conflicts = 0;
      for (const FleetAnnouncement& other : all)
        if (other.robot != one.robot && std::count(lit.begin(), lit.end(), other.robot) > 0 &&
            in_conflict(own, other.claims[0].claim))
          ++conflicts;
      if (std::count(lit.begin(), lit.end(), one.robot) > 0)
        ASSERT_TRUE(own.ready && conflicts == 0) << trial;
      else
        ASSERT_TRUE(!own.ready || conflicts > 0) << trial;
    }
  }
}

TEST(FleetChecks, NamesTheFaultOfAClaim) {
  EXPECT_EQ(fault_of_claim(claim(-1000, true, quad(-2, 3, 1.5, 0.7))), nullptr);
  EXPECT_NE(fault_of_claim(claim(1001)), nullptr);
  EXPECT_NE(fault_of_claim({"", 0, false, true, {}}), nullptr);
  EXPECT_NE(fault_of_claim({"a\x01", 0, false, true, {}}), nullptr);
  EXPECT_NE(fault_of_claim(claim(1, false, {{0, 0}, {1, 0}})), nullptr);
  EXPECT_NE(fault_of_claim(claim(1, false, {{0, 0}, {0, 1}, {1, 0}})), nullptr) << "the other order";
  EXPECT_NE(fault_of_claim(claim(1, false, {{0, 0}, {2, 0}, {0.5, 0.5}, {0, 2}})), nullptr) << "not convex";
  EXPECT_NE(fault_of_claim(claim(1, false, {{0, 0}, {1, 0}, {1, std::nan("")}})), nullptr);
  EXPECT_NE(fault_of_claim(claim(1, false, Points2(33, Vec2(0, 0)))), nullptr);
  EXPECT_NE(fault_of_claims(std::vector<FleetClaim>(2, claim(1))), nullptr) << "one surface twice";
  std::vector<FleetClaim> many;
  for (int i = 0; i < 65; ++i) many.push_back({"s" + std::to_string(i), 0, false, true, {}});
  EXPECT_NE(fault_of_claims(many), nullptr);
  many.pop_back();
  EXPECT_EQ(fault_of_claims(many), nullptr);
}

/// A frame on its way to the wall.
struct Light {
  double from = 0;
  std::map<std::string, FleetClaim> on;  ///< by surface, with the claim at the time
};

/// A robot whose show draws frames that are on the wall some time later.
struct Robot {
  Robot(const std::string& robot_name, std::uint64_t incarnation, double begin)
      : name(robot_name),
        turns({"hall", robot_name, 0.02}, incarnation, begin + 1),
        begun(begin),
        frame_due(begin) {}

  void frame(double now) {
    Light light{now + delay, {}};
    const Names lit = turns.lit();
    for (const FleetClaim& one : claims)
      if (std::count(lit.begin(), lit.end(), one.surface) > 0) light.on[one.surface] = claimed(one.surface);
    Names surfaces;
    for (const auto& [surface, unused] : light.on) surfaces.push_back(surface);
    turns.shown(surfaces, light.from);
    wall.push_back(std::move(light));
    frame_due = now + period;
  }
  /// As it was announced when it was drawn.
  FleetClaim claimed(const std::string& surface) {
    for (const auto& one : turns.announce(0).claims)
      if (one.claim.surface == surface) return one.claim;
    return {};
  }
  const Light& seen(double now) {
    while (wall.size() > 1 && wall[1].from <= now) wall.erase(wall.begin());
    static const Light dark;
    return wall.empty() || wall.front().from > now ? dark : wall.front();
  }

  std::string name;
  FleetTurns turns;
  std::vector<FleetClaim> claims;
  std::vector<Light> wall;
  double begun, frame_due, period = 1 / 60., delay = 0.013, sent = -1;
  bool runs = true, is_stuck = false;
};

/// Robots in a network that delays, loses and reorders. Steps of 1 ms.
class Hall {
 public:
  explicit Hall(std::uint64_t seed) : random_(seed) {}

  Robot& add(const std::string& name) {
    robots_.push_back(std::make_unique<Robot>(name, 1000000 * ++starts_, now_));
    return *robots_.back();
  }
  /// Its program ends, and its light with it; the others learn of it within half a second.
  void kill(Robot& robot) {
    robot.runs = false;
    robot.wall.clear();
    forgotten_.push_back({now_ + uniform(0, 0.5), robot.name});
  }
  void run(
      double seconds, const std::function<void()>& each = [] {}) {
    for (const double end = now_ + seconds; now_ < end; now_ += 0.001) {
      each();
      deliver();
      for (const auto& robot : robots_) {
        if (!robot->runs || robot->is_stuck) continue;
        robot->turns.claim(robot->claims);
        const bool changed = robot->turns.step(now_);
        if (changed || now_ - robot->sent >= 0.5) send(*robot);
        if (now_ >= robot->frame_due) robot->frame(now_);
      }
      look();
    }
  }
  double uniform(double from, double to) { return std::uniform_real_distribution<>(from, to)(random_); }
  int pick(int n) { return int(random_() % std::uint64_t(n)); }
  Names lit(const std::string& surface) {
    Names names;
    for (const auto& robot : robots_)
      if (robot->runs && robot->seen(now_).on.count(surface) > 0) names.push_back(robot->name);
    std::sort(names.begin(), names.end());
    return names;
  }
  /// By what each robot announces now.
  std::map<std::string, Names> decision() {
    std::vector<FleetAnnouncement> all;
    for (const auto& robot : robots_)
      if (robot->runs) all.push_back(robot->turns.announce(0));
    return fleet_decision(all);
  }
  std::vector<std::unique_ptr<Robot>>& robots() { return robots_; }

  double max_delay = 0.03, lost = 0;
  int doubles = 0;                    ///< milliseconds with light of two robots in conflict
  std::map<std::string, double> gap;  ///< by surface, the time without any light since it had some
  std::map<std::string, double> max_gap;

 private:
  struct Message {
    double arrival;
    Robot* to;
    FleetAnnouncement announcement;
  };
  void send(Robot& from) {
    from.sent = now_;
    const FleetAnnouncement sent = from.turns.announce(now_);
    for (const auto& to : robots_)
      if (to.get() != &from && (is_new(from) || is_new(*to) || uniform(0, 1) >= lost))
        messages_.push_back({now_ + uniform(0.0001, max_delay), to.get(), sent});
  }
  /// DDS is reliable: robots find each other, and only what a newer announcement follows may be lost.
  bool is_new(const Robot& robot) const { return now_ < robot.begun + 1; }
  void deliver() {
    for (std::size_t i = 0; i < messages_.size();) {
      if (messages_[i].arrival > now_) {
        ++i;
        continue;
      }
      if (messages_[i].to->runs) messages_[i].to->turns.take(messages_[i].announcement);
      messages_.erase(messages_.begin() + std::ptrdiff_t(i));
    }
    for (std::size_t i = 0; i < forgotten_.size();) {
      if (forgotten_[i].first > now_) {
        ++i;
        continue;
      }
      for (const auto& robot : robots_) robot->turns.forget(forgotten_[i].second, now_ + 1);
      messages_.erase(
          std::remove_if(messages_.begin(), messages_.end(),
                         [&](const Message& one) { return one.announcement.robot == forgotten_[i].second; }),
          messages_.end());
      forgotten_.erase(forgotten_.begin() + std::ptrdiff_t(i));
    }
  }
  void look() {
    std::set<std::string> bright;
    for (std::size_t i = 0; i < robots_.size(); ++i)
      for (const auto& [surface, claim] : robots_[i]->seen(now_).on) {
        bright.insert(surface);
        for (std::size_t j = 0; j < i; ++j) {
          const auto& others = robots_[j]->seen(now_).on;
          const auto other = others.find(surface);
          if (other != others.end() && in_conflict(claim, other->second)) ++doubles;
        }
      }
    for (const std::string& surface : bright) gap.emplace(surface, 0).first->second = 0;
    for (auto& [surface, dark] : gap)
      if (bright.count(surface) == 0) max_gap[surface] = std::max(max_gap[surface], dark += 0.001);
  }

  std::mt19937_64 random_;
  double now_ = 0;
  std::uint64_t starts_ = 0;
  std::vector<std::unique_ptr<Robot>> robots_;
  std::vector<Message> messages_;
  std::vector<std::pair<double, std::string>> forgotten_;
};

TEST(FleetTurns, ARobotAloneLightsAfterItHasLookedForOthers) {
  Hall hall(1);
  hall.add("a").claims = {claim(0)};
  hall.run(0.99);
  EXPECT_TRUE(hall.lit("wall").empty());
  hall.run(0.1);
  EXPECT_EQ(hall.lit("wall"), Names{"a"});
}

/// The robot that gives up keeps its light until the other is ready, and the dark time is a message, a frame and its delay.
TEST(FleetTurns, HandOverWaitsUntilTheNextRobotIsReadyAndIsShort) {
  double longest = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Hall hall(seed);
    Robot& old = hall.add("old");
    old.claims = {claim(1)};
    hall.add("third").claims = {claim(-3)};
    hall.run(1.5);
    ASSERT_EQ(hall.lit("wall"), Names{"old"});
    Robot& next = hall.add("young");
    next.delay = 0.021;
    FleetClaim late = claim(5);
    late.ready = false;
    next.claims = {late};
    hall.run(2, [&] { ASSERT_EQ(hall.lit("wall"), Names{"old"}); });
    hall.max_gap.clear();
    next.claims = {claim(5)};
    hall.run(1);
    ASSERT_EQ(hall.lit("wall"), Names{"young"});
    longest = std::max(longest, hall.max_gap["wall"]);
    ASSERT_EQ(hall.doubles, 0);
  }
  // One message, a frame, its delay, and a step of 1 ms at either end.
  EXPECT_LE(longest, 0.03 + 1 / 60. + 0.021 + 0.002);
  EXPECT_GT(longest, 0.021) << "longer than the delay of a frame: it is a hand-over";
  RecordProperty("longest_dark_ms", int(1e3 * longest));
}

/// A robot that lives but does not answer, such as a program in a debugger.
TEST(FleetTurns, ARobotThatDoesNotAnswerStopsAHandOverAndTheLightStays) {
  Hall hall(5);
  hall.add("old").claims = {claim(1)};
  Robot& third = hall.add("third");
  third.claims = {claim(-3)};
  hall.run(1.5);
  hall.add("young").claims = {claim(5)};
  third.is_stuck = true;
  hall.run(3, [&] { ASSERT_EQ(hall.lit("wall"), Names{"old"}); });
  third.is_stuck = false;
  hall.run(1);
  EXPECT_EQ(hall.lit("wall"), Names{"young"});
}

TEST(FleetTurns, EqualRobotsDoNotAlternate) {
  Hall hall(3);
  hall.add("b").claims = {claim(2)};
  hall.run(1.5);
  hall.add("a").claims = {claim(2)};
  hall.run(5, [&] { ASSERT_EQ(hall.lit("wall"), Names{"b"}); });
}

TEST(FleetTurns, AKilledRobotIsReplacedAndItsNextStartTakesOverWithoutADoubleImage) {
  Hall hall(4);
  hall.add("strong").claims = {claim(7)};
  hall.add("weak").claims = {claim(2)};
  hall.run(1.5);
  ASSERT_EQ(hall.lit("wall"), Names{"strong"});
  hall.kill(*hall.robots()[0]);
  hall.run(0.6);
  EXPECT_EQ(hall.lit("wall"), Names{"weak"});
  hall.add("strong").claims = {claim(7)};
  hall.run(2);
  EXPECT_EQ(hall.lit("wall"), Names{"strong"});
  EXPECT_EQ(hall.doubles, 0);
}

TEST(FleetTurns, TheLaterStartOfANameSupersedesTheEarlier) {
  FleetTurns first({"hall", "spot"}, 100, 0);
  first.claim({claim(1)});
  first.step(1);
  ASSERT_EQ(first.lit(), Names{"wall"});
  FleetAnnouncement twin = announcement("spot", claim(1));
  twin.incarnation = 99;
  first.take(twin);
  first.step(1.1);
  EXPECT_EQ(first.lit(), Names{"wall"});
  twin.incarnation = 101;
  first.take(twin);
  first.step(1.2);
  EXPECT_TRUE(first.lit().empty());
  EXPECT_TRUE(first.status().is_superseded);
  first.shown({}, 1.25);
  first.forget("spot", 2.3);
  first.step(2.2);
  EXPECT_TRUE(first.lit().empty());
  first.step(2.3);
  EXPECT_EQ(first.lit(), Names{"wall"});
}

TEST(FleetTurns, ARobotTooManyIsRefusedAndLightsNothing) {
  FleetTurns turns({"hall", "spot"}, 100, 0);
  for (int i = 0; i < 63; ++i)
    EXPECT_EQ(turns.take(announcement("r" + std::to_string(i), claim(0))), Taken::kNew);
  FleetAnnouncement more = announcement("r63", claim(0), true);
  EXPECT_EQ(turns.take(more), Taken::kRefused);
  turns.step(1);
  for (const auto& grant : turns.announce(1).grants) EXPECT_NE(grant.robot, "r63");
}

/// 30 fleets of 2 to 4 robots on two surfaces for 12 s, whose claims change at random (priority, blend, ready, region,
/// given up), while messages are late by up to 0.2 s, come in any order, and one in five is lost; robots join, and one is
/// killed and started again. No two robots in conflict ever light, and in quiet the light is the decision.
TEST(FleetTurns, NeverTwoInConflictUnderDelayLossAndReordering) {
  for (std::uint64_t seed = 100; seed < 130; ++seed) {
    Hall hall(seed);
    hall.max_delay = 0.001 + 0.2 * hall.uniform(0, 1);
    hall.lost = 0.2;
    const auto changed = [&](Robot& robot) {
      robot.claims.clear();
      for (const char* const surface : {"wall", "floor"}) {
        if (hall.pick(5) == 0) continue;
        FleetClaim one{surface, hall.pick(3), hall.pick(3) == 0, hall.pick(4) != 0, {}};
        if (hall.pick(2) == 0)
          one.region = quad(0.5 * hall.pick(4), 0.3 * hall.pick(3), 0.4 + 0.5 * hall.pick(3), 0.7);
        robot.claims.push_back(one);
      }
    };
    const int count = 2 + hall.pick(3);
    for (int r = 0; r < count; ++r) {
      Robot& robot = hall.add("robot" + std::to_string(r));
      robot.delay = hall.uniform(0.005, 0.09);
      robot.period = hall.uniform(0.01, 0.04);
      changed(robot);
      if (hall.pick(2) == 0) hall.run(hall.uniform(0, 1.5));
    }
    const auto stir = [&] {
      if (hall.pick(300) == 0) changed(*hall.robots()[std::size_t(hall.pick(count))]);
    };
    hall.run(4, stir);
    hall.kill(*hall.robots().front());
    hall.run(1, stir);
    changed(hall.add("robot0"));
    hall.run(4, stir);
    ASSERT_EQ(hall.doubles, 0) << "seed " << seed;
    hall.run(3);  // in quiet
    ASSERT_EQ(hall.doubles, 0) << "seed " << seed;
    const auto decision = hall.decision();
    for (const char* const surface : {"wall", "floor"}) {
      const auto chosen = decision.find(surface);
      ASSERT_EQ(hall.lit(surface), chosen == decision.end() ? Names() : chosen->second)
          << "seed " << seed << ", " << surface;
    }
  }
}

}  // namespace
}  // namespace procam::dds::internal
