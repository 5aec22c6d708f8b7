#include <algorithm>
#include <tuple>

#include "procam/core/geometry/convex.hpp"
#include "procam/dds/fleet.hpp"

namespace procam::dds {
namespace {

/// A side of `a` that has all of `b` outside.
bool separates(const Points2& a, const Points2& b) {
  const std::vector<HalfPlane> sides = half_planes(a);
  return std::any_of(sides.begin(), sides.end(), [&](const HalfPlane& side) {
    return std::all_of(b.begin(), b.end(), [&](const Vec2& p) { return side.normal.dot(p) >= side.offset; });
  });
}

bool overlap(const Points2& a, const Points2& b) {
  if (a.empty() || b.empty()) return true;
  return !separates(a, b) && !separates(b, a);
}

struct Candidate {
  const std::string* robot;
  const FleetAnnouncement::Claim* announced;

  bool is_before(const Candidate& other) const {
    using Rank = std::tuple<int, bool, const std::string&>;
    const auto rank = [](const Candidate& c) {
      return Rank(-c.announced->claim.priority, !c.announced->lights, *c.robot);
    };
    return rank(*this) < rank(other);
  }
};

}  // namespace

bool in_conflict(const FleetClaim& a, const FleetClaim& b) {
  return a.surface == b.surface && !(a.blend && b.blend) && overlap(a.region, b.region);
}

std::map<std::string, std::vector<std::string>> fleet_decision(
    const std::vector<FleetAnnouncement>& announcements) {
  std::map<std::string, std::vector<Candidate>> by_surface;
  for (const FleetAnnouncement& one : announcements)
    for (const FleetAnnouncement::Claim& announced : one.claims)
      if (announced.claim.ready) by_surface[announced.claim.surface].push_back({&one.robot, &announced});
  std::map<std::string, std::vector<std::string>> decision;
  for (auto& [surface, candidates] : by_surface) {
    std::sort(candidates.begin(), candidates.end(),
              [](const Candidate& a, const Candidate& b) { return a.is_before(b); });
    std::vector<Candidate> chosen;
    for (const Candidate& next : candidates)
      if (std::none_of(chosen.begin(), chosen.end(), [&](const Candidate& before) {
            return in_conflict(before.announced->claim, next.announced->claim);
          }))
        chosen.push_back(next);
    std::vector<std::string>& robots = decision[surface];
    for (const Candidate& one : chosen) robots.push_back(*one.robot);
    std::sort(robots.begin(), robots.end());
  }
  return decision;
}

}  // namespace procam::dds
