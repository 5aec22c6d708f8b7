#include "group_members.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "group_limits.hpp"

namespace procam::dds::internal {
namespace {

constexpr double kSlew = 1e-3;       ///< group time is corrected by no more, seconds a second
constexpr double kGoodClock = 5e-4;  ///< bound of an error that is followed at once, seconds
constexpr double kClockWait = 2;     ///< before a worse one is taken, of a member that joins, seconds
constexpr double kDrift = 5e-5;      ///< of two clocks, from the last estimate on, seconds a second
constexpr double kSetClock = 0.05;   ///< a larger correction is made at once, seconds
constexpr double kSettle = 1;  ///< members that were together for so long are one half of a network, seconds

auto leader_rank(const MemberBeat& beat) {
  return std::make_tuple(beat.settled, beat.term, beat.strength, beat.member);
}
auto strength_rank(const MemberBeat& beat) {
  return std::make_tuple(beat.strength, beat.member);
}

}  // namespace

GroupMembers::GroupMembers(MemberBeat own, double begin, double lease, double first_wait)
    : own_(std::move(own)), lease_(lease), may_lead_(begin + first_wait), decided_(begin), settling_(begin) {}

void GroupMembers::take(const MemberBeat& beat, double arrival) {
  if (beat.member == own_.member) return;
  if (others_.size() >= limits::kGroupMembers && others_.count(beat.member) == 0) return;
  Other& other = others_[beat.member];
  other.beat = beat;
  other.last = arrival;
  other.clock.observe(beat.sent, arrival);
}

void GroupMembers::set_state(std::uint64_t term) {
  own_.has_state = true;
  own_.term = std::max(own_.term, term);
}

const MemberBeat* GroupMembers::leader() const {
  const MemberBeat* found = nullptr;
  for (const auto& [member, other] : others_)
    if (other.beat.leads && (found == nullptr || leader_rank(other.beat) > leader_rank(*found)))
      found = &other.beat;
  return found;
}

bool GroupMembers::is_strongest() const {
  return std::none_of(others_.begin(), others_.end(), [&](const auto& item) {
    const MemberBeat& other = item.second.beat;
    if (own_.has_state && !other.has_state) return false;
    return (other.has_state && !own_.has_state) || strength_rank(other) > strength_rank(own_);
  });
}

void GroupMembers::decide(double now) {
  for (auto other = others_.begin(); other != others_.end();)
    other = now - other->second.last > lease_ ? others_.erase(other) : std::next(other);
  // A process that stood still may have been replaced meanwhile.
  if (now - decided_ > lease_) {
    own_.leads = false;
    may_lead_ = std::max(may_lead_, now + lease_);
  }
  decided_ = now;
  settle(now);
  const MemberBeat* const other = leader();
  if (other != nullptr && own_.leads && leader_rank(*other) > leader_rank(own_)) own_.leads = false;
  if (own_.leads) outdo_terms();
  if (other != nullptr && !own_.leads) {
    note_leader(other->member, now);
    leader_last_ = others_.at(other->member).last;
    follow_clock(others_.at(other->member), now);
  } else if (other == nullptr && !own_.leads && now >= may_lead_ && is_strongest()) {
    for (const auto& [member, one] : others_) own_.term = std::max(own_.term, one.beat.term);
    ++own_.term;
    own_.leads = clock_known_ = true;
    note_leader(own_.member, now);
  }
  if (own_.leads) leader_last_ = now;
}

/// The number of members falls at once and rises after a second or two: while two halves meet, each has its own.
void GroupMembers::settle(double now) {
  const auto members = std::uint32_t(count());
  if (now - settling_ >= kSettle) {
    settling_ = now;
    least_before_ = std::exchange(least_now_, members);
  }
  least_now_ = std::min(least_now_, members);
  own_.settled = std::min(least_before_, least_now_);
}

/// Members of another half take a state of a greater term than their own. Its leader may have given up unseen.
void GroupMembers::outdo_terms() {
  for (const auto& [member, other] : others_)
    if (other.beat.term > own_.term || (other.beat.leads && other.beat.term == own_.term))
      own_.term = other.beat.term + 1;
}

void GroupMembers::note_leader(std::uint64_t member, double now) {
  if (member == known_leader_) return;
  if (known_leader_ != 0) {
    ++takeovers_;
    last_takeover_ = now - leader_last_;
  }
  known_leader_ = member;
}

void GroupMembers::follow_clock(const Other& leader, double now) {
  double offset = leader.beat.group_offset;
  clock_is_shared_ = leader.beat.machine == own_.machine;
  if (clock_is_shared_) {
    own_.group_offset = offset;
    clock_error_ = 0;
    clock_known_ = true;
    return;
  }
  const auto back = std::find_if(leader.beat.offsets.begin(), leader.beat.offsets.end(),
                                 [&](const MemberOffset& one) { return one.member == own_.member; });
  if (back == leader.beat.offsets.end()) return;
  const track::Clock::Estimate forth = leader.clock.estimate();
  offset += (back->offset - forth.offset) / 2;
  const double error = std::max(0.0, (back->offset + forth.offset) / 2) + (back->sigma + forth.sigma) / 2;
  // The first messages of a leader may have waited on a busy machine: what is known from before is better.
  const double known_error = clock_error_ + kDrift * (now - slewed_);
  if (clock_known_ && error > kGoodClock && error > known_error) {
    clock_error_ = known_error;
    slewed_ = now;
    return;
  }
  clock_error_ = error;
  const double step = offset - own_.group_offset, most = kSlew * (now - slewed_);
  if (!clock_known_ || std::abs(step) > kSetClock)
    own_.group_offset = offset;
  else
    own_.group_offset += std::clamp(step, -most, most);
  slewed_ = now;
  if (follows_since_ == 0) follows_since_ = now;
  clock_known_ = clock_known_ || error <= kGoodClock || now - follows_since_ >= kClockWait;
}

void GroupMembers::light(double from) {
  own_.lit = !own_.projectors.empty();
  own_.lit_from = from;
}

std::vector<GroupLight> GroupMembers::lights() const {
  std::vector<GroupLight> lights;
  for (const auto& [member, other] : others_)
    if (other.beat.lit)
      for (const std::string& projector : other.beat.projectors)
        lights.push_back({projector, other.beat.lit_from, member});
  return lights;
}

MemberBeat GroupMembers::last_beat(double now) const {
  MemberBeat last = beat(now);
  last.lit = false;
  return last;
}

MemberBeat GroupMembers::beat(double now) const {
  MemberBeat beat = own_;
  beat.sent = now;
  for (const auto& [member, other] : others_) {
    const track::Clock::Estimate estimate = other.clock.estimate();
    beat.offsets.push_back({member, estimate.offset, estimate.sigma});
  }
  return beat;
}

}  // namespace procam::dds::internal
