#include "fleet_turns.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "fleet_limits.hpp"

namespace procam::dds::internal {
namespace {

bool equal(const FleetClaim& a, const FleetClaim& b) {
  return a.surface == b.surface && a.priority == b.priority && a.blend == b.blend && a.ready == b.ready &&
         a.region == b.region;
}

bool equal(const FleetAnnouncement& a, const FleetAnnouncement& b) {
  return std::equal(a.claims.begin(), a.claims.end(), b.claims.begin(), b.claims.end(),
                    [](const auto& x, const auto& y) {
                      return equal(x.claim, y.claim) && x.turn == y.turn && x.lights == y.lights;
                    }) &&
         std::equal(a.grants.begin(), a.grants.end(), b.grants.begin(), b.grants.end(),
                    [](const auto& x, const auto& y) {
                      return x.robot == y.robot && x.surface == y.surface && x.turn == y.turn;
                    });
}

bool has(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool grants_turn(const FleetAnnouncement& by, const std::string& robot, const std::string& surface,
                 std::uint64_t turn) {
  return std::any_of(by.grants.begin(), by.grants.end(), [&](const FleetAnnouncement::Grant& grant) {
    return grant.turn == turn && grant.robot == robot && grant.surface == surface;
  });
}

const FleetAnnouncement::Claim* claim_of(const FleetAnnouncement& announcement, const std::string& surface) {
  for (const FleetAnnouncement::Claim& one : announcement.claims)
    if (one.claim.surface == surface) return &one;
  return nullptr;
}

}  // namespace

// Turns of another start of the robot have other numbers: a grant to that one is none to this one.
FleetTurns::FleetTurns(const FleetOptions& options, std::uint64_t incarnation, double begins)
    : options_(options), incarnation_(incarnation), next_turn_(incarnation), begins_(begins) {}

void FleetTurns::claim(const std::vector<FleetClaim>& claims) {
  for (auto& [surface, own] : own_) own.next.reset();
  for (const FleetClaim& claim : claims) {
    Own& own = own_[claim.surface];
    if (own.claim.surface.empty()) own.claim = claim;
    own.next = claim;
  }
}

Taken FleetTurns::take(const FleetAnnouncement& announcement) {
  if (announcement.robot == options_.robot) {
    is_superseded_ = is_superseded_ || announcement.incarnation > incarnation_;
    return announcement.incarnation > incarnation_ ? Taken::kNew : Taken::kOlder;
  }
  const auto known = others_.find(announcement.robot);
  if (known == others_.end()) {
    if (others_.size() + 1 >= limits::kFleetRobots) return Taken::kRefused;
    others_.emplace(announcement.robot, announcement);
    return Taken::kNew;
  }
  const auto place = [](const FleetAnnouncement& one) { return std::tuple(one.incarnation, one.sequence); };
  if (place(announcement) <= place(known->second)) return Taken::kOlder;
  known->second = announcement;
  return Taken::kNew;
}

void FleetTurns::forget(const std::string& robot, double begins) {
  others_.erase(robot);
  if (robot == options_.robot && std::exchange(is_superseded_, false)) begins_ = begins;
}

void FleetTurns::shown(const std::vector<std::string>& surfaces, double light_time) {
  for (auto& [surface, own] : own_) {
    if (own.state != State::kEnds) continue;
    if (has(surfaces, surface))
      own.dark_from.reset();
    else if (!own.dark_from)
      own.dark_from = light_time;
  }
}

bool FleetTurns::keeps_turn(Own& own) {
  if (!own.next) return false;
  if (own.state != State::kDark &&
      (own.next->blend != own.claim.blend || own.next->region != own.claim.region))
    return false;
  own.claim = *own.next;
  return true;
}

bool FleetTurns::is_granted(const Own& own) const {
  return std::all_of(others_.begin(), others_.end(), [&](const auto& other) {
    return grants_turn(other.second, options_.robot, own.claim.surface, own.turn);
  });
}

bool FleetTurns::is_granted_by_others(const std::string& robot, const FleetAnnouncement::Claim& asked) const {
  return std::all_of(others_.begin(), others_.end(), [&](const auto& other) {
    if (other.first == robot) return true;
    const auto* theirs = claim_of(other.second, asked.claim.surface);
    // One that lights in conflict waits for this robot as this robot would wait for it.
    if (theirs != nullptr && theirs->lights && in_conflict(theirs->claim, asked.claim)) return true;
    return grants_turn(other.second, robot, asked.claim.surface, asked.turn);
  });
}

bool FleetTurns::has_successor(const Own& own, const std::vector<std::string>& chosen) const {
  return std::any_of(chosen.begin(), chosen.end(), [&](const std::string& robot) {
    const auto other = others_.find(robot);
    if (other == others_.end()) return false;
    const auto* theirs = claim_of(other->second, own.claim.surface);
    if (theirs == nullptr || theirs->turn == 0 || !in_conflict(theirs->claim, own.claim)) return false;
    return theirs->lights || is_granted_by_others(robot, *theirs);
  });
}

void FleetTurns::step(Own& own, bool should, double now) {
  switch (own.state) {
    case State::kDark:
      if (!should) return;
      own.turn = ++next_turn_;
      own.asked = now;
      own.state = State::kAsks;
      [[fallthrough]];  // without others nobody is asked
    case State::kAsks:
      if (!should) {
        own.state = State::kDark;
        own.turn = 0;
      } else if (is_granted(own)) {
        own.state = State::kLights;
        ++turns_;
        last_wait_ = now - own.asked;
      }
      return;
    case State::kLights:
    case State::kEnds:
      return;
  }
}

bool FleetTurns::step(double now) {
  std::vector<FleetAnnouncement> all;
  for (const auto& [robot, other] : others_) all.push_back(other);
  std::map<std::string, bool> keeps;
  for (auto& [surface, own] : own_) keeps[surface] = keeps_turn(own) && !is_superseded_ && now >= begins_;
  all.push_back(content());
  const auto decision = fleet_decision(all);
  for (auto it = own_.begin(); it != own_.end();) {
    Own& own = it->second;
    const auto chosen = decision.find(it->first);
    const bool may = keeps[it->first] && own.claim.ready;
    const bool should = may && chosen != decision.end() && has(chosen->second, options_.robot);
    if (own.state == State::kLights && !should && (!may || has_successor(own, chosen->second))) {
      own.state = State::kEnds;
      own.dark_from.reset();
    } else if (own.state == State::kEnds && own.dark_from && now >= *own.dark_from) {
      own.state = State::kDark;
      own.turn = 0;
    } else {
      step(own, should, now);
    }
    it = own.state == State::kDark && !own.next ? own_.erase(it) : std::next(it);
  }
  FleetAnnouncement next = content();
  const bool changed = !equal(next, announced_);
  announced_ = std::move(next);
  return changed;
}

std::vector<FleetAnnouncement::Grant> FleetTurns::grants() const {
  std::vector<FleetAnnouncement::Grant> granted;
  for (const auto& [robot, other] : others_)
    for (const FleetAnnouncement::Claim& asked : other.claims) {
      if (asked.turn == 0) continue;
      const auto own = own_.find(asked.claim.surface);
      if (own != own_.end() && own->second.turn != 0 && in_conflict(own->second.claim, asked.claim)) continue;
      granted.push_back({robot, asked.claim.surface, asked.turn});
    }
  return granted;
}

FleetAnnouncement FleetTurns::content() const {
  FleetAnnouncement now;
  now.robot = options_.robot;
  now.incarnation = incarnation_;
  now.latency = options_.latency;
  for (const auto& [surface, own] : own_)
    now.claims.push_back({own.claim, own.turn, own.state == State::kLights || own.state == State::kEnds});
  now.grants = grants();
  return now;
}

FleetAnnouncement FleetTurns::announce(double stamp) {
  announced_.sequence = ++sequence_;
  announced_.stamp = stamp;
  return announced_;
}

std::vector<std::string> FleetTurns::lit() const {
  std::vector<std::string> surfaces;
  for (const auto& [surface, own] : own_)
    if (own.state == State::kLights) surfaces.push_back(surface);
  return surfaces;
}

FleetStatus FleetTurns::status() const {
  FleetStatus status;
  status.robots = int(others_.size()) + 1;
  status.turns = turns_;
  status.last_wait = last_wait_;
  status.is_superseded = is_superseded_;
  status.largest_latency = options_.latency;
  const auto add = [&](const FleetAnnouncement& one) {
    status.largest_latency = std::max(status.largest_latency, one.latency);
    for (const auto& announced : one.claims)
      if (announced.lights) status.by[announced.claim.surface].push_back(one.robot);
  };
  add(content());
  for (const auto& [robot, other] : others_) {
    add(other);
    for (const auto& announced : other.claims)
      if (announced.claim.ready) ++status.others[announced.claim.surface];
  }
  for (auto& [surface, robots] : status.by) std::sort(robots.begin(), robots.end());
  return status;
}

}  // namespace procam::dds::internal
