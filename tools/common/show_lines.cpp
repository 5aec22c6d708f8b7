#include "common/show_lines.hpp"

namespace procam::tools {
namespace {

/// A name within a JSON pointer (RFC 6901).
std::string pointer_part(const std::string& name) {
  std::string part;
  for (const char letter : name) part += letter == '~' ? "~0" : letter == '/' ? "~1" : std::string(1, letter);
  return part;
}

}  // namespace

void print_group(const show::GroupMetrics& group, Console& console) {
  console.say(format(
      "group: %d hosts, led by %s, content time within %.3f ms of the leader's, takeovers: %llu", group.hosts,
      group.leader.c_str(), 1e3 * group.clock_error_s, (unsigned long long)group.takeovers));
  Summary& summary = console.summary();
  summary.set("/group/hosts", double(group.hosts));
  summary.set("/group/leads", group.leads ? 1.0 : 0.0);
  summary.set("/group/clock_error_ms", 1e3 * group.clock_error_s);
  summary.set("/group/takeovers", double(group.takeovers));
}

void print_fleet(const show::FleetMetrics& fleet, Console& console) {
  console.say(format("fleet: %d robots, this one lit surfaces %llu times, refused announcements: %llu%s",
                     fleet.robots, (unsigned long long)fleet.turns, (unsigned long long)fleet.rejected,
                     fleet.is_superseded ? "; another robot has its name" : ""));
  Summary& summary = console.summary();
  summary.set("/fleet/robots", double(fleet.robots));
  summary.set("/fleet/lit", double(fleet.lit));
  summary.set("/fleet/turns", double(fleet.turns));
  summary.set("/fleet/last_wait_ms", 1e3 * fleet.last_wait_s);
  summary.set("/fleet/rejected", double(fleet.rejected));
}

void print_tracked(const std::vector<show::MovingMetrics>& surfaces, Console& console) {
  for (const show::MovingMetrics& one : surfaces) {
    console.say(
        format("tracked '%s': seen in %llu images, refused in %llu, lost %llu times for %.1f s in all",
               one.surface.c_str(), (unsigned long long)one.sightings, (unsigned long long)one.refused,
               (unsigned long long)one.losses, one.lost_s));
    const std::string at = "/tracked/" + pointer_part(one.surface);
    console.summary().set(at + "/sightings", double(one.sightings));
    console.summary().set(at + "/refused", double(one.refused));
    console.summary().set(at + "/losses", double(one.losses));
    console.summary().set(at + "/lost_s", one.lost_s);
  }
}

}  // namespace procam::tools
