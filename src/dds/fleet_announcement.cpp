#include "fleet_announcement.hpp"

#include <cmath>
#include <vector>

#include "fleet_checks.hpp"
#include "fleet_limits.hpp"
#include "procam/core/base/detail/plain_text.hpp"
#include "procam/core/base/limits.hpp"

namespace procam::dds::internal {
namespace {

void require_valid(bool valid, const char* why) {
  if (!valid) throw Refusal{"fleet_invalid", why};
}

std::string text_or_empty(const char* text) {
  return text == nullptr ? std::string() : std::string(text);
}

FleetAnnouncement::Claim read_claim(const procam_fleet_Claim& message) {
  FleetAnnouncement::Claim read;
  read.claim.surface = text_or_empty(message.surface);
  read.claim.priority = message.priority;
  read.claim.blend = message.blend;
  read.claim.ready = message.ready;
  require_valid(message.region._length <= limits::kFleetRegionCorners, "a region has too many corners");
  for (std::uint32_t i = 0; i < message.region._length; ++i)
    read.claim.region.emplace_back(message.region._buffer[i].x, message.region._buffer[i].y);
  read.turn = message.turn;
  read.lights = message.lights;
  require_valid(!read.lights || read.turn != 0, "a surface is lit without a turn");
  return read;
}

FleetAnnouncement::Grant read_grant(const procam_fleet_Grant& message) {
  FleetAnnouncement::Grant read{text_or_empty(message.robot), text_or_empty(message.surface), message.turn};
  require_valid(is_fleet_name(read.robot), "a grant names no robot");
  require_valid(!read.surface.empty() && read.surface.size() <= limits::kFrameNameBytes &&
                    procam::internal::is_plain_text(read.surface),
                "a grant names no surface");
  require_valid(read.turn != 0, "a grant has no turn");
  return read;
}

template <typename Sequence, typename Element>
Sequence borrowed(std::vector<Element>& elements) {
  Sequence sequence{};
  sequence._buffer = elements.data();
  sequence._length = sequence._maximum = std::uint32_t(elements.size());
  return sequence;
}

}  // namespace

FleetAnnouncement read_announcement(const procam_fleet_Announcement& message, const std::string& fleet) {
  FleetAnnouncement read;
  require_valid(text_or_empty(message.fleet) == fleet, "it is of another fleet");
  read.robot = text_or_empty(message.robot);
  require_valid(is_fleet_name(read.robot), "it names no robot");
  read.incarnation = message.incarnation;
  read.sequence = message.sequence_number;
  read.stamp = message.stamp;
  read.latency = message.latency;
  require_valid(std::isfinite(read.stamp), "its time is not finite");
  require_valid(read.latency >= 0 && read.latency <= limits::kFleetLatencyS, "no light is that late");
  require_valid(message.claims._length <= limits::kFleetClaims, "it has too many surfaces");
  require_valid(message.grants._length <= limits::kFleetGrants, "it has too many grants");
  std::vector<FleetClaim> claims;
  for (std::uint32_t i = 0; i < message.claims._length; ++i) {
    read.claims.push_back(read_claim(message.claims._buffer[i]));
    claims.push_back(read.claims.back().claim);
  }
  if (const char* const fault = fault_of_claims(claims)) throw Refusal{"fleet_invalid", fault};
  for (std::uint32_t i = 0; i < message.grants._length; ++i)
    read.grants.push_back(read_grant(message.grants._buffer[i]));
  return read;
}

dds_return_t write_announcement(dds_entity_t writer, const std::string& fleet,
                                FleetAnnouncement announcement) {
  std::string name = fleet;  // C structures point to texts that may be written
  std::vector<std::vector<procam_fleet_Corner>> regions;
  std::vector<procam_fleet_Claim> claims;
  std::vector<procam_fleet_Grant> grants;
  for (auto& [claim, turn, lights] : announcement.claims) {
    std::vector<procam_fleet_Corner>& region = regions.emplace_back();
    for (const Vec2& corner : claim.region) region.push_back({corner.x(), corner.y()});
    procam_fleet_Claim& written = claims.emplace_back();
    written.surface = claim.surface.data();
    written.priority = claim.priority;
    written.blend = claim.blend;
    written.ready = claim.ready;
    // The corners stay where they are when `regions` grows: vectors are moved.
    written.region = borrowed<decltype(written.region)>(region);
    written.turn = turn;
    written.lights = lights;
  }
  for (FleetAnnouncement::Grant& grant : announcement.grants)
    grants.push_back({grant.robot.data(), grant.surface.data(), grant.turn});
  procam_fleet_Announcement message{};
  message.robot = announcement.robot.data();
  message.fleet = name.data();
  message.incarnation = announcement.incarnation;
  message.sequence_number = announcement.sequence;
  message.stamp = announcement.stamp;
  message.latency = announcement.latency;
  message.claims = borrowed<decltype(message.claims)>(claims);
  message.grants = borrowed<decltype(message.grants)>(grants);
  return dds_write(writer, &message);
}

}  // namespace procam::dds::internal
