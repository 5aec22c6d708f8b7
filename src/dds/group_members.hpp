#pragma once
/// The members of a group, without DDS: who is there, who leads, and what their clocks are.
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "procam/dds/group.hpp"
#include "procam/track/clock.hpp"

namespace procam::dds::internal {

/// The receiver's steady clock less that of a member, with the shortest delay in it, seconds.
struct MemberOffset {
  std::uint64_t member = 0;
  double offset = 0, sigma = 0;
};

/// What a member sends of itself, 20 times a second.
struct MemberBeat {
  std::uint64_t member = 0;
  std::string host;           ///< "stage-left:4711"
  std::uint64_t machine = 0;  ///< equal: one steady clock
  int strength = 0;
  bool leads = false, has_state = false;
  std::uint64_t term = 0;     ///< counts the leaders
  std::uint32_t settled = 1;  ///< members that have been together for a second, with this one
  double sent = 0;            ///< its steady time
  double group_offset = 0;    ///< group time less its steady time
  std::vector<std::string> projectors = {};
  bool lit = false;     ///< all of them
  double lit_from = 0;  ///< group time
  std::vector<MemberOffset> offsets = {};
};

class GroupMembers {
 public:
  /// `own`: member, host, machine and strength. `lease`, `first_wait`: Group::kLease and kFirstWait.
  GroupMembers(MemberBeat own, double begin, double lease, double first_wait);

  void take(const MemberBeat& beat, double arrival);
  /// Forgets silent members, and decides who leads; slews the clock. To be called at least 10 times in a lease. Of two
  /// leaders that meet, that of the larger half stays, and takes a term above that of the other, whose state it replaces.
  void decide(double now);
  /// A state of that term is here.
  void set_state(std::uint64_t term);

  bool leads() const { return own_.leads; }
  std::uint64_t term() const { return own_.term; }
  bool clock_known() const { return clock_known_; }
  double group_offset() const { return own_.group_offset; }
  double clock_error() const { return own_.leads ? 0 : clock_error_; }
  bool clock_is_shared() const { return own_.leads || clock_is_shared_; }
  const MemberBeat* leader() const;  ///< another member; null: none
  /// No other leader is known than this member.
  bool may_follow(std::uint64_t member) const {
    const MemberBeat* const known = leader();
    return known == nullptr || known->member == member;
  }
  bool has(std::uint64_t member) const { return member == own_.member || others_.count(member) > 0; }
  int count() const { return int(others_.size()) + 1; }
  void light(double from);
  /// To be sent before the member ends.
  MemberBeat last_beat(double now) const;
  std::vector<GroupLight> lights() const;
  std::uint64_t takeovers() const { return takeovers_; }
  double last_takeover() const { return last_takeover_; }
  /// To be sent.
  MemberBeat beat(double now) const;

 private:
  struct Other {
    MemberBeat beat;
    double last = 0;  ///< arrival of its last beat
    track::Clock clock;
  };
  void note_leader(std::uint64_t member, double now);
  void settle(double now);
  void outdo_terms();
  bool is_strongest() const;
  void follow_clock(const Other& leader, double now);

  MemberBeat own_;
  double lease_, may_lead_ = 0, decided_ = 0;
  std::map<std::uint64_t, Other> others_;
  std::uint64_t known_leader_ = 0, takeovers_ = 0;
  double leader_last_ = 0, last_takeover_ = 0;
  double settling_ = 0;                             ///< begin of the present second
  std::uint32_t least_now_ = 1, least_before_ = 1;  ///< members in it and in the one before, at least
  bool clock_known_ = false, clock_is_shared_ = true;
  double clock_error_ = 0, slewed_ = 0, follows_since_ = 0;
};

}  // namespace procam::dds::internal
