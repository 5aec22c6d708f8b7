// A group by real DDS traffic on the loopback interface: between processes where one is killed, else between participants.
#include "procam/dds/group.hpp"

#include <gtest/gtest.h>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <thread>

#include "graph_values.hpp"
#include "group_messages.h"
#include "member_process.hpp"
#include "procam/core/base/clock.hpp"
#include "ros2_peer.hpp"
#include "support/expect_error.hpp"

namespace procam::dds {
namespace {

using test::LoopbackDomain;
using test::MemberProcess;
using test::wait_until;

GroupState some_state(const std::string& surfaces = "first") {
  GroupState state;
  state.surfaces = surfaces;
  state.content_epoch = 1234.5625;
  state.picture = 1;
  state.frozen = true;
  state.frozen_at = 17.125;
  state.can_undo = true;
  state.saves = 3;
  return state;
}

void expect_state(const GroupState& state, const GroupState& expected) {
  EXPECT_EQ(state.surfaces, expected.surfaces);
  EXPECT_EQ(state.content_epoch, expected.content_epoch);
  EXPECT_EQ(state.picture, expected.picture);
  EXPECT_EQ(state.frozen, expected.frozen);
  EXPECT_EQ(state.frozen_at, expected.frozen_at);
  EXPECT_EQ(state.unsaved, expected.unsaved);
  EXPECT_EQ(state.can_undo, expected.can_undo);
  EXPECT_EQ(state.can_redo, expected.can_redo);
  EXPECT_EQ(state.saves, expected.saves);
}

std::optional<GroupState> next_state(Group& group, double seconds = 5) {
  std::optional<GroupState> state;
  wait_until([&] { return (state = group.take()).has_value(); }, seconds);
  return state;
}

/// Publishes a state each time that a request comes, for ever.
void lead(Group& group) {
  GroupState state = some_state();
  for (bool begun = false;;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    if (!group.leads()) continue;
    bool changed = !std::exchange(begun, true);
    for (const GroupRequest& request : group.take_requests()) {
      if (request.command == "refused") {
        group.finish(request, "it cannot be done");
      } else {
        state.surfaces += " " + request.command;
        group.finish(request);
      }
      changed = true;
    }
    if (changed) group.publish(state);
  }
}

TEST(Group, ALateMemberGetsTheStateAndItsRequestsComeBackInOneOrder) {
  const LoopbackDomain domain;
  const MemberProcess leader([] {
    Group group({"stage", 9});
    lead(group);
  });
  Group early({"stage", 1});
  ASSERT_TRUE(wait_until([&] { return early.joined(); }));
  EXPECT_FALSE(early.leads());
  const auto first = next_state(early);
  ASSERT_TRUE(first);
  expect_state(*first, some_state());

  Group late({"stage", 5});
  const double begin = steady_now();
  const auto at_once = next_state(late);
  ASSERT_TRUE(at_once);
  EXPECT_LT(steady_now() - begin, 2) << "the state does not wait for the next change";
  expect_state(*at_once, some_state());

  for (int i = 0; i < 20; ++i) {
    early.request("e" + std::to_string(i));
    late.request("l" + std::to_string(i));
  }
  early.request("refused");
  GroupState of_early, of_late;
  const std::size_t expected = std::string("first").size() + 2 * (10 * 3 + 10 * 4);
  EXPECT_TRUE(wait_until([&] {
    if (const auto state = early.take()) of_early = *state;
    if (const auto state = late.take()) of_late = *state;
    return early.status().waiting == 0 && late.status().waiting == 0 &&
           of_early.surfaces == of_late.surfaces && of_early.surfaces.size() >= expected;
  })) << of_early.surfaces;
  std::size_t last_e = 0, last_l = 0;
  for (int i = 0; i < 20; ++i) {
    const std::string text = of_early.surfaces + " ";
    const std::size_t e = text.find(" e" + std::to_string(i) + " "),
                      l = text.find(" l" + std::to_string(i) + " ");
    ASSERT_NE(e, text.npos) << i << text;
    ASSERT_NE(l, text.npos) << i << text;
    EXPECT_GE(e, last_e) << text;
    EXPECT_GE(l, last_l) << text;
    last_e = e;
    last_l = l;
  }
  EXPECT_EQ(of_early.surfaces.size(), expected) << "each once";
  EXPECT_EQ(early.take_refusals(), std::vector<std::string>{"it cannot be done"});
  EXPECT_TRUE(late.take_refusals().empty());
}

/// An end of the topic of a group's state, in another process as far as DDS is concerned.
dds_entity_t state_end(const test::Ros2Peer& peer, bool writes) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_ownership(qos, DDS_OWNERSHIP_EXCLUSIVE);
  dds_qset_liveliness(qos, DDS_LIVELINESS_AUTOMATIC, DDS_MSECS(400));
  const dds_entity_t topic = dds_create_topic(peer.participant(), &procam_group_State_desc,
                                              "procam/group/stage/state", nullptr, nullptr);
  const dds_entity_t end = writes ? dds_create_writer(peer.participant(), topic, qos, nullptr)
                                  : dds_create_reader(peer.participant(), topic, qos, nullptr);
  dds_delete_qos(qos);
  EXPECT_GT(end, 0) << dds_strretcode(end);
  return end;
}

/// A leader writes the state again each second; who comes between does not wait for it.
TEST(Group, TheStateIsKeptForLateMembers) {
  const LoopbackDomain domain;
  const test::Ros2Peer peer(domain);
  std::string group = "stage", surfaces = "written once";
  procam_group_State state{};
  state.group = group.data();
  state.surfaces = surfaces.data();
  state.leader = 7;
  state.term = 3;
  const dds_entity_t writer = state_end(peer, true);
  ASSERT_EQ(dds_write(writer, &state), DDS_RETCODE_OK);
  Group late({"stage", 1});
  const auto taken = next_state(late);
  ASSERT_TRUE(taken);
  EXPECT_EQ(taken->surfaces, "written once");
  // And as a leader it keeps its own.
  ASSERT_TRUE(wait_until([&] { return late.leads(); }));
  dds_delete(writer);
  ASSERT_TRUE(late.publish(some_state("kept")));
  const test::Ros2Peer later(domain);
  const dds_entity_t reader = state_end(later, false);
  std::string read;
  EXPECT_TRUE(wait_until([&] {
    void* samples[1] = {};
    dds_sample_info_t info;
    if (dds_take(reader, samples, &info, 1, 1) < 1) return false;
    if (info.valid_data) read = static_cast<const procam_group_State*>(samples[0])->surfaces;
    dds_return_loan(reader, samples, 1);
    return !read.empty();
  }));
  EXPECT_EQ(read, "kept");
}

TEST(Group, AMembersLightIsKnownUntilItEndsOrIsKilled) {
  const LoopbackDomain domain;
  MemberProcess killed([] {
    Group group({"stage", 1, {}, {"right"}});
    group.light(12.25);
    lead(group);
  });
  Group here({"stage", 5, {}, {"left"}});
  ASSERT_TRUE(wait_until([&] { return here.status().lights.size() == 1; }));
  EXPECT_EQ(here.status().lights[0].projector, "right");
  EXPECT_EQ(here.status().lights[0].from, 12.25);
  {
    Group ending({"stage", 1, {}, {"far"}});
    ASSERT_TRUE(wait_until([&] { return here.status().members == 3; }));
    EXPECT_EQ(here.status().lights.size(), 1u) << "it has not called light()";
    ending.light(13);
    ASSERT_TRUE(wait_until([&] { return here.status().lights.size() == 2; }));
  }
  const double ended = steady_now();
  ASSERT_TRUE(wait_until([&] { return here.status().lights.size() == 1; }));
  EXPECT_LT(steady_now() - ended, 0.25) << "at once, not after the lease";
  killed.end();
  const double begin = steady_now();
  ASSERT_TRUE(wait_until([&] { return here.status().lights.empty(); }));
  EXPECT_LT(steady_now() - begin, 0.7);
  RecordProperty("gone_ms", int(1e3 * (steady_now() - begin)));
}

TEST(Group, WhenTheLeaderIsKilledTheStrongestContinuesFromTheLastState) {
  const LoopbackDomain domain;
  MemberProcess leader([] {
    Group group({"stage", 9});
    lead(group);
  });
  Group weak({"stage", 1}), strong({"stage", 5});
  ASSERT_TRUE(wait_until([&] { return weak.joined() && strong.joined() && weak.status().members == 3; }));
  strong.request("edited");
  ASSERT_TRUE(wait_until([&] { return strong.status().waiting == 0; }));
  const double offset = strong.time_offset();
  while (weak.take()) {
  }
  leader.end();
  const double killed = steady_now();
  weak.request("asked while nobody leads");
  ASSERT_TRUE(wait_until([&] { return strong.leads(); }));
  const double takeover = steady_now() - killed;
  EXPECT_LT(takeover, 1);
  RecordProperty("takeover_ms", int(1e3 * takeover));
  EXPECT_EQ(strong.time_offset(), offset) << "group time does not jump";
  // The state goes on from the last one, at once and without a word of the show.
  const auto taken_over = next_state(weak);
  RecordProperty("state_ms", int(1e3 * (steady_now() - killed)));
  ASSERT_TRUE(taken_over);
  expect_state(*taken_over, some_state("first edited"));
  // What was asked meanwhile is not lost.
  std::vector<GroupRequest> requests;
  EXPECT_TRUE(wait_until([&] {
    for (GroupRequest& request : strong.take_requests()) requests.push_back(std::move(request));
    return !requests.empty();
  }));
  ASSERT_EQ(requests.size(), 1u);
  EXPECT_EQ(requests[0].command, "asked while nobody leads");
  strong.finish(requests[0]);
  EXPECT_TRUE(strong.publish(some_state("second")));
  const auto changed = next_state(weak);
  ASSERT_TRUE(changed);
  EXPECT_EQ(changed->surfaces, "second");
  EXPECT_EQ(weak.status().waiting, 0u);
  EXPECT_FALSE(weak.publish(some_state("of a follower")));
}

TEST(Group, APoseReachesTheOthersDigitByDigit) {
  const LoopbackDomain domain;
  Group source({"stage", 1}), other({"stage", 2});
  ASSERT_TRUE(wait_until([&] { return source.status().members == 2 && other.leads(); }));
  other.publish(some_state());
  ASSERT_TRUE(wait_until([&] { return source.joined(); }));
  track::StampedPose sent;
  sent.frame = "map";
  sent.child = "robot";
  sent.frame_from_child = test::some_pose(2);
  sent.stamp = 1.7e9 + 0.1;
  sent.arrival = steady_now();
  sent.covariance = Mat6::Identity() * 0.3;
  (*sent.covariance)(1, 4) = 0.017;
  sent.angular_rate = Vec3(0.1, 0.2, -0.3);
  sent.sequence = 77;
  std::vector<track::StampedPose> arrived;
  EXPECT_TRUE(wait_until([&] {
    if (arrived.empty()) source.publish_pose(sent);
    arrived = other.take_poses();
    return !arrived.empty();
  }));
  ASSERT_FALSE(arrived.empty());
  const track::StampedPose& pose = arrived.front();
  EXPECT_EQ(pose.stamp, sent.stamp);
  EXPECT_EQ(pose.arrival, sent.arrival);
  EXPECT_EQ(pose.frame, sent.frame);
  EXPECT_EQ(pose.child, sent.child);
  EXPECT_EQ(pose.frame_from_child.rotation.coeffs(), sent.frame_from_child.rotation.coeffs());
  EXPECT_EQ(pose.frame_from_child.translation, sent.frame_from_child.translation);
  EXPECT_EQ(*pose.covariance, *sent.covariance);
  EXPECT_FALSE(pose.twist);
  EXPECT_EQ(*pose.angular_rate, *sent.angular_rate);
  EXPECT_EQ(pose.sequence, sent.sequence);
}

/// Another machine, as far as the group is concerned: the clocks agree in truth, so that the offset is the error.
TEST(Group, AcrossMachinesTheClockIsEstimatedAndItsErrorReported) {
  const LoopbackDomain domain;
  Group leader({"stage", 9, "machine a"}), other({"stage", 1, "machine b"});
  ASSERT_TRUE(wait_until([&] { return leader.leads(); }));
  leader.publish(some_state());
  ASSERT_TRUE(wait_until([&] { return other.joined(); }));
  const GroupStatus status = other.status();
  EXPECT_FALSE(status.clock_is_shared);
  EXPECT_GT(status.clock_error, 0);
  EXPECT_LE(std::abs(other.time_offset()), status.clock_error + 1e-6);
  EXPECT_EQ(leader.status().clock_error, 0);
  RecordProperty("clock_error_us", int(1e6 * status.clock_error));
}

TEST(Group, InvalidMessagesAreCountedAndChangeNothing) {
  const LoopbackDomain domain;
  Group group({"stage", 1});
  const test::Ros2Peer peer(domain);
  const dds_entity_t topic = dds_create_topic(peer.participant(), &procam_group_Beat_desc,
                                              "procam/group/stage/member", nullptr, nullptr);
  const dds_entity_t writer = dds_create_writer(peer.participant(), topic, nullptr, nullptr);
  std::string host = "a";
  procam_group_Beat beat{};
  beat.member = 5;
  beat.host = host.data();
  beat.leads = true;
  beat.sent = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(wait_until([&] {
    dds_write(writer, &beat);
    return group.status().rejected > 0;
  }));
  EXPECT_EQ(group.status().members, 1);
  EXPECT_TRUE(wait_until([&] { return group.leads(); })) << "no member that is none holds it up";
}

TEST(Group, NamesAndStrengthsThatCannotBeAreRefused) {
  EXPECT_ERROR(Group({""}), kInput, "group ''");
  EXPECT_ERROR(Group({"a/b"}), kInput, "group 'a/b'");
  EXPECT_ERROR(Group({std::string(65, 'a')}), kInput, "group");
  EXPECT_ERROR(Group({"stage", 1001}), kInput, "strength 1001");
}

}  // namespace
}  // namespace procam::dds
