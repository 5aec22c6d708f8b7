#include "fleet_link.hpp"

#include <algorithm>
#include <cstdio>
#include <set>
#include <utility>

#include "name_list.hpp"

namespace procam::show {
namespace {

/// Points along the sides of the content and within it, in each direction.
constexpr int kReachSamples = 8;

/// Some light of the projector can fall on it.
bool reaches(const Projector& projector, const Placement& placement) {
  const auto is_in_frame = [&](const std::optional<Vec2>& pixel) {
    return pixel && projector.size().contains(*pixel);
  };
  if (const auto* mesh = std::get_if<PlacedMesh>(&placement))
    return mesh->mesh &&
           std::any_of(mesh->mesh->vertices.begin(), mesh->mesh->vertices.end(), [&](const Vec3& vertex) {
             return is_in_frame(projector.project(Vec3(mesh->projector_from_surface * vertex)));
           });
  const auto* plane = std::get_if<PlacedPlane>(&placement);
  if (plane == nullptr) return true;  // in pixels of the projector
  for (int j = 0; j <= kReachSamples; ++j)
    for (int i = 0; i <= kReachSamples; ++i) {
      const Vec3 h =
          plane->plane_from_content * Vec3(double(i) / kReachSamples, double(j) / kReachSamples, 1);
      if (!(h.z() > 0)) continue;
      const Vec3 point(h.x() / h.z(), h.y() / h.z(), 0);
      if (is_in_frame(projector.project(Vec3(plane->projector_from_surface * point)))) return true;
    }
  return false;
}

dds::FleetOptions fleet_options(const ShowOptions& options, double latency) {
  dds::FleetOptions fleet;
  fleet.name = options.fleet;
  fleet.robot = options.robot;
  fleet.latency = latency;
  return fleet;
}

}  // namespace

FleetLink::FleetLink(const ShowOptions& options, double latency)
    : fleet_(fleet_options(options, latency)),
      name_(options.fleet),
      robot_(options.robot),
      priority_(options.fleet_priority),
      blends_(options.fleet_blend) {}

std::vector<std::string> FleetLink::dark(const Show& show) const {
  const std::vector<std::string> lit = fleet_.lit();
  std::vector<std::string> dark;
  for (const Surface& surface : show.surfaces.surfaces)
    if (std::find(lit.begin(), lit.end(), surface.name) == lit.end()) dark.push_back(surface.name);
  return dark;
}

Points2 FleetLink::region_of(const std::string& surface, const Placement& placement,
                             const Projector& projector, const dds::FleetStatus& status, double light_time) {
  const auto* plane = std::get_if<PlacedPlane>(&placement);
  if (plane == nullptr) return {};
  Region& region = regions_[surface];
  const Points2& announced = region.announced.follow(reached_region(projector, *plane), light_time);
  // Another region has a dark time: none without need, and not back again.
  region.is_shared = region.is_shared || status.others.count(surface) > 0;
  return region.is_shared ? announced : Points2();
}

void FleetLink::shown(const Projection& projection, bool is_drawn, double light_time) {
  std::vector<dds::FleetClaim> claims;
  lit_.clear();
  std::set<std::string> seen;
  const dds::FleetStatus status = fleet_.status();
  const std::vector<SolvedSurface>& surfaces = projection.solved().surfaces;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const std::string& name = surfaces[i].surface.name;
    const SurfaceLight light = is_drawn ? projection.light(i) : SurfaceLight::kNone;
    if (light == SurfaceLight::kShown) lit_.push_back(name);
    if (!seen.insert(name).second) continue;
    dds::FleetClaim claim;
    claim.surface = name;
    claim.priority = priority_;
    claim.blend = blends_;
    claim.ready = light != SurfaceLight::kNone && reaches(projection.projector(), surfaces[i].placement);
    claim.region = region_of(name, surfaces[i].placement, projection.projector(), status, light_time);
    claims.push_back(std::move(claim));
  }
  fleet_.shown(lit_, light_time);
  fleet_.claim(claims);
}

std::vector<std::string> FleetLink::take_news() {
  std::vector<std::string> news;
  const std::string fleet = "fleet " + name_ + ": ";
  dds::FleetStatus status = fleet_.status();
  for (const auto& [surface, robots] : status.by)
    if (told_.by[surface] != robots) news.push_back(fleet + joined(robots) + " lights '" + surface + "'");
  if (status.robots != told_.robots)
    news.push_back(fleet + std::to_string(status.robots) + (status.robots == 1 ? " robot" : " robots"));
  if (status.is_superseded && !told_.is_superseded)
    news.push_back(fleet + "another robot has the name '" + robot_ +
                   "' and was started later; this one is dark; give each robot a name of its own");
  if (status.rejected > 0 && told_.rejected == 0)
    news.push_back(fleet + "an announcement was refused: it is invalid or too large");
  told_ = std::move(status);
  return news;
}

FleetMetrics FleetLink::metrics() const {
  const dds::FleetStatus status = fleet_.status();
  FleetMetrics metrics;
  metrics.robots = status.robots;
  metrics.by = status.by;
  for (const auto& [surface, robots] : status.by)
    metrics.lit += std::find(robots.begin(), robots.end(), robot_) != robots.end() ? 1 : 0;
  metrics.turns = status.turns;
  metrics.last_wait_s = status.last_wait;
  metrics.rejected = status.rejected;
  metrics.is_superseded = status.is_superseded;
  metrics.largest_latency_s = status.largest_latency;
  return metrics;
}

}  // namespace procam::show
