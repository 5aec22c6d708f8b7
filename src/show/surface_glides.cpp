#include "surface_glides.hpp"

#include "procam/core/geometry/se3.hpp"

namespace procam::show {
namespace {

/// Null: there is none of that name, or it is in no frame of the room.
const InRoom* placed_surface(const SurfaceSet& set, const std::string& name) {
  for (const Surface& surface : set.surfaces)
    if (surface.name == name) return place_of(surface.geometry);
  return nullptr;
}

}  // namespace

void SurfaceGlides::begin(const SurfaceSet& set, const std::string& surface, const Vec6& moved, double error,
                          const Frames& frames, double now) {
  const InRoom* const place = placed_surface(set, surface);
  if (place == nullptr) return;
  Before& before = before_.try_emplace(surface, Before{place->frame_from_surface, 0}).first->second;
  before.error += error;
  const Pose rig_from_frame = place->frame == "rig"         ? Pose()
                              : place->frame == "projector" ? frames.rig_from_projector
                                                            : frames.rig_from_world;
  const Pose target =
      (rig_from_frame.inverse() * se3_exp<double>(moved) * rig_from_frame * place->frame_from_surface)
          .normalized();
  moving_.insert_or_assign(surface, watch::Glide(place->frame_from_surface, target, error, now));
}

void SurfaceGlides::undo(const SurfaceSet& set, double now) {
  for (const auto& [surface, before] : before_)
    if (const InRoom* const place = placed_surface(set, surface))
      moving_.insert_or_assign(
          surface, watch::Glide(place->frame_from_surface, before.frame_from_surface, before.error, now));
  before_.clear();
}

void SurfaceGlides::apply(SurfaceSet& set, double now) {
  for (Surface& surface : set.surfaces) {
    const auto moving = moving_.find(surface.name);
    if (moving == moving_.end()) continue;
    if (InRoom* const place = place_of(surface.geometry)) place->frame_from_surface = moving->second.at(now);
  }
  for (auto moving = moving_.begin(); moving != moving_.end();)
    moving = moving->second.is_over(now) ? moving_.erase(moving) : std::next(moving);
}

}  // namespace procam::show
