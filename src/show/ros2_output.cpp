#include "ros2_output.hpp"

#include <algorithm>
#include <chrono>

#include "graph_markers.hpp"
#include "light_shift.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/core/base/words.hpp"
#include "run_options.hpp"

namespace procam::show {
namespace {

constexpr double kStatusPeriod = 1, kMovingPeriod = 1 / 30.0;  // seconds

bool are_equal(const std::vector<FrameTree::Link>& a, const std::vector<FrameTree::Link>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& one, const auto& other) {
    return one.target == other.target && one.source == other.source &&
           one.target_from_source.pose.matrix() == other.target_from_source.pose.matrix();
  });
}

std::optional<Pose> projector_from(const Placement& placement) {
  if (const auto* plane = std::get_if<PlacedPlane>(&placement)) return plane->projector_from_surface;
  if (const auto* mesh = std::get_if<PlacedMesh>(&placement)) return mesh->projector_from_surface;
  return std::nullopt;
}

double unix_now() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

}  // namespace

Ros2Output::Ros2Output(const ShowOptions& options, const Rig& rig, const Pose& base_from_rig,
                       const std::optional<Pose>& world_from_rig)
    : options_(options),
      rig_(rig),
      base_from_rig_(base_from_rig),
      world_from_rig_(world_from_rig),
      publisher_(options.publish),
      images_(publisher_, rig.projector(options.projector).name) {
  if (!options.track) return;
  for (const auto& [names, markers] : options.track->surfaces) tracked_.push_back(split_names(names));
}

std::vector<FrameTree::Link> Ros2Output::frames(const Projection& projection) const {
  std::vector<FrameTree::Link> links;
  const auto add = [&](const std::string& parent, const std::string& child, const Pose& pose) {
    links.push_back({parent, child, {pose, Mat6::Zero()}});
  };
  const std::string rig = publisher_.frame("rig");
  std::string world = options_.frame.empty() ? projection.track().frame() : options_.frame;
  if (world.empty() && world_from_rig_) world = "map";
  const std::string base = options_.child.empty() ? projection.track().child() : options_.child;
  if (world_from_rig_)
    add(world, rig, *world_from_rig_);
  else if (!base.empty())
    add(base, rig, base_from_rig_);
  for (const RigCamera& camera : rig_.cameras)
    add(rig, publisher_.frame(camera.name), camera.rig_from_camera);
  // A correction has moved the projector that shows; its pose is not that of the rig file then.
  const std::string& shown = rig_.projector(options_.projector).name;
  for (const RigProjector& one : rig_.projectors)
    add(rig, publisher_.frame(one.name),
        one.name == shown ? projection.rig_from_projector() : one.rig_from_projector);
  const std::string projector = publisher_.frame(shown);
  for (const Surface& surface : projection.show().surfaces.surfaces) {
    const InRoom* place = place_of(surface.geometry);
    if (place == nullptr || is_tracked(surface.name)) continue;
    const std::string& parent = place->frame == "rig" ? rig : place->frame == "projector" ? projector : world;
    if (!parent.empty()) add(parent, publisher_.frame("surfaces/" + surface.name), place->frame_from_surface);
  }
  return links;
}

bool Ros2Output::is_tracked(const std::string& surface) const {
  return std::any_of(tracked_.begin(), tracked_.end(), [&](const std::vector<std::string>& body) {
    return std::find(body.begin(), body.end(), surface) != body.end();
  });
}

std::vector<FrameTree::Link> Ros2Output::moving_frames(const Projection& projection) const {
  std::vector<FrameTree::Link> links;
  for (const MovingState& state : projection.moving()) {
    if (state.seen.state != track::TrackState::kFresh) continue;
    const auto body = std::find_if(tracked_.begin(), tracked_.end(),
                                   [&](const auto& names) { return names.front() == state.surface; });
    for (const SolvedSurface& surface : projection.solved().surfaces) {
      if (body == tracked_.end() ||
          std::find(body->begin(), body->end(), surface.surface.name) == body->end())
        continue;
      const std::optional<Pose> placed = projector_from(surface.placement);
      if (placed)
        links.push_back({publisher_.frame("rig"),
                         publisher_.frame("surfaces/" + surface.surface.name),
                         {projection.rig_from_projector() * *placed, Mat6::Zero()}});
    }
  }
  return links;
}

std::vector<dds::GraphMarker> Ros2Output::markers(const Projection& projection) const {
  const RigProjector& projector = rig_.projector(options_.projector);
  std::vector<dds::GraphMarker> markers;
  double length = 1;  // metres; to the farthest surface
  const SolvedSurfaceSet& solved = projection.solved();
  const track::TrackedPose pose = projection.track().at(steady_now());
  for (const SolvedSurface& surface : solved.surfaces) {
    const InRoom* place = place_of(surface.surface.geometry);
    if (place == nullptr) continue;
    const std::string frame = publisher_.frame("surfaces/" + surface.surface.name);
    markers.push_back(outline_marker(surface, frame));
    if (const auto* plane = std::get_if<PlacedPlane>(&surface.placement))
      if (const auto centre = content_centre(*plane))
        length = std::max(length, (plane->projector_from_surface * Vec3(centre->x(), centre->y(), 0)).z());
    if (place->frame != "world" || !solved.projector_from_world || pose.state == track::TrackState::kNone)
      continue;
    for (dds::GraphMarker& error :
         error_markers(surface, frame, solved.projector_from_world->inverse(), pose.covariance))
      markers.push_back(std::move(error));
  }
  markers.push_back(
      frustum_marker(projector.projector.inverse_camera, publisher_.frame(projector.name), length));
  return markers;
}

/// What happened since the last publication.
dds::DeviceHealth Ros2Output::health(const Projection& projection, const Metrics& metrics) {
  dds::DeviceHealth health;
  health.name = "procam: " + rig_.projector(options_.projector).name;
  std::string faults;
  for (const auto& [name, count] : metrics.faults) {
    const auto known = before_.faults.find(name);
    const std::uint64_t fresh = count - (known == before_.faults.end() ? 0 : known->second);
    if (fresh > 0) faults += (faults.empty() ? "" : ", ") + name + " " + std::to_string(fresh);
    health.values.emplace_back("fault " + name, std::to_string(count));
  }
  const std::uint64_t blanked = metrics.blanked - before_.blanked, dark = metrics.dark - before_.dark;
  if (projection.track().newest_time() == 0 && metrics.waiting > before_.waiting) {
    health.level = dds::HealthLevel::kStale;
    health.message = "no pose has arrived";
  } else if (blanked > 0) {
    health.level = dds::HealthLevel::kWarning;
    health.message = std::to_string(blanked) + " frames are black: the pose is too old";
  } else if (dark > 0) {
    health.level = dds::HealthLevel::kWarning;
    health.message = "no light reaches a surface";
  } else if (metrics.watch && metrics.watch->is_alarm) {
    health.level = dds::HealthLevel::kWarning;
    health.message = metrics.watch->sentence;
  } else if (!faults.empty()) {
    health.level = dds::HealthLevel::kWarning;
    health.message = "faults: " + faults;
  } else {
    health.message = "projecting";
  }
  const std::pair<const char*, std::uint64_t> counts[] = {{"frames", metrics.frames},
                                                          {"frames dropped", metrics.dropped},
                                                          {"frames blanked", metrics.blanked},
                                                          {"poses", metrics.poses},
                                                          {"poses malformed", metrics.malformed}};
  for (const auto& [name, count] : counts) health.values.emplace_back(name, std::to_string(count));
  if (metrics.watch) {
    health.values.emplace_back("watch", metrics.watch->state);
    health.values.emplace_back("watch error (mm)", fixed(metrics.watch->error_mm, 2));
    health.values.emplace_back("watch checks", std::to_string(metrics.watch->checks));
    health.values.emplace_back("watch alarms", std::to_string(metrics.watch->alarms));
    health.values.emplace_back("watch corrections", std::to_string(metrics.watch->corrections));
  }
  for (const MovingMetrics& moving : metrics.moving)
    health.values.emplace_back("tracked surface " + moving.surface, moving.is_dark ? "dark" : moving.state);
  if (metrics.group) {
    health.values.emplace_back("group hosts", std::to_string(metrics.group->hosts));
    health.values.emplace_back("group leader", metrics.group->leader);
    health.values.emplace_back("group clock error (ms)", std::to_string(1e3 * metrics.group->clock_error_s));
  }
  before_ = metrics;
  return health;
}

void Ros2Output::publish_pose(const track::StampedPose& message, double delay) {
  const double age = steady_now() - message.arrival + delay;
  publisher_.publish_pose(
      message.frame, {message.frame_from_child, message.covariance.value_or(Mat6::Zero())}, unix_now() - age);
}

void Ros2Output::publish(const Projection& projection, const Metrics& metrics) {
  const double now = steady_now();
  if (!tracked_.empty() && now >= moved_ + kMovingPeriod) {
    moved_ = now;
    const std::vector<FrameTree::Link> moving = moving_frames(projection);
    if (!moving.empty()) publisher_.publish_moving_frames(moving, unix_now() + options_.delay_s);
  }
  if (now < published_ + kStatusPeriod) return;
  published_ = now;
  const RigProjector& projector = rig_.projector(options_.projector);
  publisher_.publish_camera_info(projector.name, projector.projector.inverse_camera, unix_now());
  publisher_.publish_health(health(projection, metrics), unix_now());
  publisher_.publish_markers(markers(projection), unix_now());
  std::vector<FrameTree::Link> links = frames(projection);
  if (are_equal(links, frames_)) return;
  publisher_.publish_frames(links, unix_now());
  frames_ = std::move(links);
}

}  // namespace procam::show
