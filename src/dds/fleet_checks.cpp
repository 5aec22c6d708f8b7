#include "fleet_checks.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "fleet_limits.hpp"
#include "procam/core/base/detail/plain_text.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/core/geometry/convex.hpp"

namespace procam::dds::internal {
namespace {

constexpr double kMaxMetres = 1e6;

/// Corners in the order of core/geometry/convex.hpp, each once around.
bool is_convex(const Points2& region) {
  if (!(area(region) > 0)) return false;
  const std::vector<HalfPlane> sides = half_planes(region);
  return std::all_of(sides.begin(), sides.end(), [&](const HalfPlane& side) {
    return side.normal.allFinite() && std::all_of(region.begin(), region.end(), [&](const Vec2& p) {
             return side.normal.dot(p) <= side.offset + 1e-9 * (1 + std::abs(side.offset));
           });
  });
}

}  // namespace

bool is_fleet_name(const std::string& name) {
  const char* const letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
  return !name.empty() && name.size() <= 64 && name.find_first_not_of(letters) == name.npos;
}

void require_fleet(const FleetOptions& options) {
  const auto require_name = [](const std::string& what, const std::string& name) {
    if (!is_fleet_name(name))
      throw Error(ErrorKind::kInput, what + " '" + name + "'", "it is no name of a " + what,
                  "give 1 to 64 letters of a-z, A-Z, 0-9, _ and -");
  };
  require_name("fleet", options.name);
  require_name("robot", options.robot);
  if (!(options.latency >= 0 && options.latency <= limits::kFleetLatencyS))
    throw Error(ErrorKind::kInput, "latency of robot '" + options.robot + "'", "no light is that late",
                "give seconds, e.g. 0.05");
}

const char* fault_of_claim(const FleetClaim& claim) {
  if (claim.surface.empty() || claim.surface.size() > limits::kFrameNameBytes ||
      !procam::internal::is_plain_text(claim.surface))
    return "the name of a surface is empty, no text, or too long";
  if (std::abs(double(claim.priority)) > limits::kFleetPriority)
    return "a priority is not from -1000 to 1000";
  if (claim.region.empty()) return nullptr;
  if (claim.region.size() < 3 || claim.region.size() > limits::kFleetRegionCorners)
    return "a region does not have 3 to 32 corners";
  if (!std::all_of(claim.region.begin(), claim.region.end(),
                   [](const Vec2& p) { return p.allFinite() && p.cwiseAbs().maxCoeff() <= kMaxMetres; }))
    return "a region is not finite";
  return is_convex(claim.region) ? nullptr : "a region is not convex, or its corners are in the other order";
}

const char* fault_of_claims(const std::vector<FleetClaim>& claims) {
  if (claims.size() > limits::kFleetClaims) return "there are more than 64 surfaces";
  std::set<std::string> names;
  for (const FleetClaim& claim : claims) {
    if (const char* const fault = fault_of_claim(claim)) return fault;
    if (!names.insert(claim.surface).second) return "two claims have one surface";
  }
  return nullptr;
}

}  // namespace procam::dds::internal
