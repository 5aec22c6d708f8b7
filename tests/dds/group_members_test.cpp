// Who leads a group, and the clocks of its members: without DDS, in a time of its own.
#include "group_members.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace procam::dds::internal {
namespace {

constexpr double kLease = 0.5, kFirstWait = 1.0;

/// A host with a steady clock of its own.
struct Host {
  Host(std::uint64_t number, int strength, double clock_offset, double drift = 0)
      : members({number, "host " + std::to_string(number), number, strength}, clock_offset, kLease,
                kFirstWait),
        offset(clock_offset),
        rate(1 + drift) {}
  double clock(double time) const { return offset + rate * time; }
  GroupMembers members;
  double offset, rate;
  bool runs = true;
};

/// Beats 20 times a second through a network with a delay.
class Network {
 public:
  explicit Network(std::vector<Host*> hosts) : hosts_(std::move(hosts)) {}
  double forth = 0.0004, back = 0.0004;  ///< to a host of a greater index, and of a smaller
  double jitter = 0;

  void run(double seconds) {
    for (const double end = now_ + seconds; now_ < end; now_ += 0.05) {
      for (std::size_t i = 0; i < hosts_.size(); ++i) {
        if (!hosts_[i]->runs) continue;
        hosts_[i]->members.decide(hosts_[i]->clock(now_));
        const MemberBeat beat = hosts_[i]->members.beat(hosts_[i]->clock(now_));
        for (std::size_t j = 0; j < hosts_.size(); ++j)
          if (j != i && hosts_[j]->runs)
            hosts_[j]->members.take(beat, hosts_[j]->clock(now_ + (j > i ? forth : back) + late_()));
      }
      for (Host* host : hosts_)  // the state of a leader reaches everybody
        for (Host* leader : hosts_)
          if (leader->runs && leader->members.leads()) host->members.set_state(leader->members.term());
    }
  }
  double now() const { return now_; }
  /// Group time of one host less that of another.
  double difference(const Host& a, const Host& b) const {
    return a.clock(now_) + a.members.group_offset() - b.clock(now_) - b.members.group_offset();
  }

 private:
  double late_() { return jitter * std::exponential_distribution<double>(1)(random_); }
  std::vector<Host*> hosts_;
  double now_ = 0;
  std::mt19937 random_{17};
};

TEST(GroupMembers, LightsAreThoseOfMembersThatAreThere) {
  Host left(11, 1, 100), right(12, 3, 7000), none(13, 2, -30);
  MemberBeat own{21, "host", 21, 0};
  own.projectors = {"right", "far"};
  right.members = GroupMembers(own, right.offset, kLease, kFirstWait);
  Network network({&left, &right, &none});
  network.run(0.3);
  EXPECT_TRUE(left.members.lights().empty()) << "it is there, and has no light yet";
  right.members.light(17.5);
  none.members.light(3);  // without a projector
  network.run(0.1);
  ASSERT_EQ(left.members.lights().size(), 2u);
  EXPECT_EQ(left.members.lights()[0].projector, "right");
  EXPECT_EQ(left.members.lights()[1].projector, "far");
  for (const GroupLight& light : left.members.lights()) {
    EXPECT_EQ(light.from, 17.5);
    EXPECT_EQ(light.member, 21u);
  }
  EXPECT_TRUE(right.members.lights().empty()) << "of others";
  right.runs = false;
  network.run(kLease - 0.1);
  EXPECT_EQ(left.members.lights().size(), 2u);
  network.run(0.3);
  EXPECT_TRUE(left.members.lights().empty());
  left.members.take(right.members.beat(5), left.clock(network.now()));
  EXPECT_EQ(left.members.lights().size(), 2u);
  left.members.take(right.members.last_beat(6), left.clock(network.now()));
  EXPECT_TRUE(left.members.lights().empty()) << "it ends, and says so";
}

TEST(GroupMembers, TheStrongestLeadsFirstAndTheNextOneTakesOver) {
  Host weak(11, 1, 100), strong(12, 3, 7000), middle(13, 2, -30);
  Network network({&weak, &strong, &middle});
  network.run(0.9);
  EXPECT_FALSE(strong.members.leads()) << "before others could be found";
  network.run(1);
  EXPECT_TRUE(strong.members.leads());
  EXPECT_FALSE(weak.members.leads() || middle.members.leads());
  const std::uint64_t term = strong.members.term();
  strong.runs = false;
  network.run(kLease + 0.2);
  EXPECT_TRUE(middle.members.leads());
  EXPECT_FALSE(weak.members.leads());
  EXPECT_EQ(middle.members.term(), term + 1);
  EXPECT_EQ(weak.members.takeovers(), 1u);
  EXPECT_LE(weak.members.last_takeover(), kLease + 0.2);
  // The one that comes back follows, though it is the strongest, and though it believed that it leads.
  strong.runs = true;
  network.run(1);
  EXPECT_TRUE(middle.members.leads());
  EXPECT_FALSE(strong.members.leads());
}

/// A member without the state would begin the show anew.
TEST(GroupMembers, OneWithoutTheStateDoesNotTakeOver) {
  Host leader(11, 1, 0), settled(12, 2, 0), fresh(13, 9, 0);
  Network network({&leader, &settled});
  leader.members.decide(0);
  network.run(2);
  Host& first = leader.members.leads() ? leader : settled;
  Host& other = leader.members.leads() ? settled : leader;
  first.runs = false;
  // The strong one has come, and has no state.
  for (double t = network.now(); t < network.now() + 2; t += 0.05) {
    fresh.members.take(other.members.beat(t), t);
    other.members.take(fresh.members.beat(t), t);
    fresh.members.decide(t);
    other.members.decide(t);
  }
  EXPECT_TRUE(other.members.leads());
  EXPECT_FALSE(fresh.members.leads());
}

/// Two halves of a network that were apart.
TEST(GroupMembers, OfTwoLeadersOneStays) {
  Host a(11, 5, 0), b(12, 2, 0);
  Network left({&a}), right({&b}), both({&a, &b});
  left.run(3);
  right.run(3);
  ASSERT_TRUE(a.members.leads() && b.members.leads());
  for (double t = 3; t < 3.4; t += 0.05)
    for (Host* host : {&a, &b}) {
      Host& other = host == &a ? b : a;
      other.members.take(host->members.beat(t), t);
      other.members.decide(t);
    }
  EXPECT_TRUE(a.members.leads());
  EXPECT_FALSE(b.members.leads());
}

/// A host whose cable was out for a while must not bring its old state back to the others, though its term is greater.
TEST(GroupMembers, OfTwoHalvesThatMeetTheLargerOneStays) {
  Host a(11, 5, 0), b(12, 4, 30), c(13, 3, -7), lone(14, 9, 100);
  std::vector<Host*> all = {&a, &b, &c, &lone};
  Network larger({&a, &b, &c}), smaller({&lone});
  larger.run(3);
  ASSERT_TRUE(a.members.leads());
  // The lone one has seen many leaders come and go.
  lone.members.set_state(7);
  smaller.run(3);
  ASSERT_TRUE(lone.members.leads());
  ASSERT_GT(lone.members.term(), a.members.term());
  const std::uint64_t others_term = lone.members.term();
  for (double t = 3; t < 3.3; t += 0.05)
    for (Host* host : all) {
      for (Host* other : all)
        if (other != host) other->members.take(host->members.beat(host->clock(t)), other->clock(t));
      host->members.decide(host->clock(t));
    }
  EXPECT_TRUE(a.members.leads());
  EXPECT_FALSE(lone.members.leads() || b.members.leads() || c.members.leads());
  EXPECT_GT(a.members.term(), others_term) << "its state replaces that of the other one";
  // The other one may have given up before it was seen to lead.
  MemberBeat follower = lone.members.beat(lone.clock(3.3));
  follower.term = 20;
  a.members.take(follower, a.clock(3.3));
  a.members.decide(a.clock(3.3));
  EXPECT_EQ(a.members.term(), 21u);
}

/// Clocks that differ by days and by 40 ppm, 0.4 ms of way and 1 ms of mean jitter: group time agrees within the bound that
/// is reported. 40 beats in both directions; the chance that no beat of 5 s has less than 0.2 ms of jitter is below 1e-8.
TEST(GroupMembers, GroupTimeAgreesWithinTheReportedBound) {
  Host leader(11, 5, 4e5, 4e-5), other(12, 2, -33, -1e-5);
  Network network({&leader, &other});
  network.jitter = 0.001;
  network.run(5);
  ASSERT_TRUE(leader.members.leads());
  ASSERT_TRUE(other.members.clock_known());
  EXPECT_FALSE(other.members.clock_is_shared());
  EXPECT_LT(std::abs(network.difference(leader, other)), other.members.clock_error());
  EXPECT_LT(other.members.clock_error(), 0.001);
  EXPECT_GT(other.members.clock_error(), 0.0003) << "half of the shortest way there and back, at least";
  // A way that is longer in one direction is not seen, and the bound holds all the same.
  network.back = 0.0024;
  network.run(70);
  EXPECT_NEAR(network.difference(leader, other), -0.001, 0.0006);
  EXPECT_LT(std::abs(network.difference(leader, other)), other.members.clock_error());
}

TEST(GroupMembers, GroupTimeDoesNotJumpWhenAnotherOneLeads) {
  Host leader(11, 5, 4e5, 4e-5), other(12, 2, -33, -1e-5);
  Network network({&leader, &other});
  network.jitter = 0.001;
  network.run(5);
  const double before = network.difference(other, leader);
  leader.runs = false;
  network.run(1);
  ASSERT_TRUE(other.members.leads());
  EXPECT_NEAR(network.difference(other, leader), before, 2e-4) << "the drift of a second, at most";
}

TEST(GroupMembers, OnOneMachineTheClockIsShared) {
  GroupMembers leader({11, "a", 5, 2}, 0, kLease, kFirstWait), other({12, "b", 5, 1}, 0, kLease, kFirstWait);
  for (double t = 0; t < 2; t += 0.05) {
    leader.decide(t);
    other.take(leader.beat(t), t + 0.2);
    other.decide(t + 0.2);
  }
  ASSERT_TRUE(leader.leads());
  EXPECT_TRUE(other.clock_known());
  EXPECT_EQ(other.group_offset(), leader.group_offset());
  EXPECT_EQ(other.clock_error(), 0);
}

}  // namespace
}  // namespace procam::dds::internal
