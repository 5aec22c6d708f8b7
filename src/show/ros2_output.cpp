#include "ros2_output.hpp"

#include <algorithm>
#include <chrono>

#include "procam/core/base/clock.hpp"

namespace procam::show {
namespace {

constexpr double kPeriod = 1;  // seconds

bool are_equal(const std::vector<FrameTree::Link>& a, const std::vector<FrameTree::Link>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& one, const auto& other) {
    return one.target == other.target && one.source == other.source &&
           one.target_from_source.pose.matrix() == other.target_from_source.pose.matrix();
  });
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
      publisher_(options.publish) {}

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
  for (const RigProjector& one : rig_.projectors)
    add(rig, publisher_.frame(one.name), one.rig_from_projector);
  const std::string projector = publisher_.frame(rig_.projector(options_.projector).name);
  for (const Surface& surface : projection.show().surfaces.surfaces) {
    const InRoom* place = place_of(surface.geometry);
    if (place == nullptr) continue;
    const std::string& parent = place->frame == "rig" ? rig : place->frame == "projector" ? projector : world;
    if (!parent.empty()) add(parent, publisher_.frame("surfaces/" + surface.name), place->frame_from_surface);
  }
  return links;
}

void Ros2Output::publish(const Projection& projection) {
  const double now = steady_now();
  if (now < published_ + kPeriod) return;
  published_ = now;
  const RigProjector& projector = rig_.projector(options_.projector);
  publisher_.publish_camera_info(projector.name, projector.projector.inverse_camera, unix_now());
  std::vector<FrameTree::Link> links = frames(projection);
  if (are_equal(links, frames_)) return;
  publisher_.publish_frames(links, unix_now());
  frames_ = std::move(links);
}

}  // namespace procam::show
