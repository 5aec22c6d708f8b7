/// The surfaces of a running show and their contents: loaded, edited, detected by a depth camera, and corrected.
#include <algorithm>
#include <cmath>
#include <map>

#include "frame_loop.hpp"

namespace procam::show {

void FrameLoop::check_contents() {
  const Show& show = parts_.projection.show();
  std::map<std::string, std::string> stopped;
  for (std::size_t i = 0; i < show.contents.size(); ++i) {
    if (!show.contents[i]) continue;
    const std::string& name = show.surfaces.surfaces[i].name;
    const auto known = stopped_contents_.find(name);
    if (const auto fault = show.contents[i]->fault()) {
      stopped[name] = fault->what();
      if (known == stopped_contents_.end() || known->second != stopped[name])
        count_fault("content", "surface '" + name + "' shows its last image: " + stopped[name]);
    } else if (known != stopped_contents_.end()) {
      say("surface '" + name + "' shows new images again");
    }
  }
  stopped_contents_ = std::move(stopped);
  metrics_.contents_stopped = stopped_contents_.size();
}

void FrameLoop::take(LoadedShow loaded) {
  for (const std::string& fault : loaded.faults) count_fault(loaded.show ? "content" : "reload", fault);
  if (loaded.from_file && parts_.group != nullptr && !parts_.group->leads()) {
    if (loaded.show && parts_.loader != nullptr) parts_.loader->retire(std::move(loaded.show->contents));
    return say("the surfaces file has changed; the surfaces of the group's leader stay");
  }
  if (!loaded.show) {
    metrics_.failed_reloads += loaded.from_file ? 1 : 0;
    return say("the surfaces from before stay");
  }
  if (!loaded.from_file && !same_names(loaded.show->surfaces)) {
    if (parts_.loader != nullptr) parts_.loader->retire(std::move(loaded.show->contents));
    return;
  }
  const SurfaceSet surfaces = loaded.show->surfaces;
  // Corners may have been dragged since contents were asked for: only those are news then.
  if (!loaded.from_file && parts_.editor != nullptr) loaded.show->surfaces = parts_.editor->surfaces();
  if (parts_.room != nullptr) {
    for (auto kept = of_room_.begin(); kept != of_room_.end();)  // asked for again when it is missed
      kept = kept->second ? std::next(kept) : of_room_.erase(kept);
    for (std::size_t i = 0; i < loaded.show->contents.size(); ++i)
      of_room_[loaded.show->surfaces.surfaces[i].content] = loaded.show->contents[i];
    show_of(parts_.projection.show().surfaces);
    return;
  }
  const bool shown = show(std::move(*loaded.show));
  if (!loaded.from_file) return;
  ++(shown ? metrics_.reloads : metrics_.failed_reloads);
  if (!shown) return;
  if (parts_.editor != nullptr) parts_.editor->replace(surfaces, true);
  say("surfaces read again");
}

bool FrameLoop::same_names(const SurfaceSet& surfaces) const {
  if (parts_.editor == nullptr) return true;
  const std::vector<Surface>& now = parts_.editor->surfaces().surfaces;
  return std::equal(
      now.begin(), now.end(), surfaces.surfaces.begin(), surfaces.surfaces.end(),
      [](const Surface& a, const Surface& b) { return a.name == b.name && a.content == b.content; });
}

bool FrameLoop::show(Show next) {
  std::vector<std::shared_ptr<device::ContentSource>> before = parts_.projection.show().contents;
  try {
    set_show(std::move(next));
  } catch (const std::exception& error) {
    count_fault("surfaces", std::string(error.what()) + "; the surfaces from before stay");
    return false;
  }
  if (parts_.loader != nullptr) parts_.loader->retire(std::move(before));
  light_.show_changed();
  ++placed_;
  surfaces_changed_ = true;
  record(parts_.projection.show().surfaces);
  return true;
}

/// On all screens or on none.
void FrameLoop::set_show(Show next) {
  if (parts_.sides == nullptr) return parts_.projection.set_show(std::move(next));
  Show before = parts_.projection.show();
  parts_.projection.set_show(std::move(next));
  try {
    parts_.sides->take_show();
  } catch (...) {
    parts_.projection.set_show(std::move(before));
    parts_.sides->take_show();
    throw;
  }
}

const SurfaceSet& FrameLoop::surfaces_now() const {
  return parts_.editor != nullptr ? parts_.editor->surfaces() : parts_.projection.show().surfaces;
}

bool FrameLoop::show_of(const SurfaceSet& surfaces) {
  const Show& before = parts_.projection.show();
  Show next;
  next.surfaces = surfaces;
  SurfaceSet missing;
  for (const Surface& surface : next.surfaces.surfaces) {
    std::shared_ptr<device::ContentSource> content;
    for (std::size_t i = 0; i < before.contents.size() && !content; ++i)
      if (before.surfaces.surfaces[i].content == surface.content) content = before.contents[i];
    // What a part of a room showed may come back.
    auto kept = of_room_.find(surface.content);
    if (!content && kept == of_room_.end() && parts_.room != nullptr)
      if (std::shared_ptr<device::ContentSource> made = parts_.room->content(surface.content))
        kept = of_room_.emplace(surface.content, std::move(made)).first;
    if (!content && kept != of_room_.end()) content = kept->second;
    if (!content && !surface.content.empty() && kept == of_room_.end()) missing.surfaces.push_back(surface);
    next.contents.push_back(std::move(content));
  }
  if (!show(std::move(next))) return false;
  if (!missing.surfaces.empty() && parts_.loader != nullptr) {
    if (parts_.room != nullptr)  // asked for once: surfaces come more often than contents open
      for (const Surface& surface : missing.surfaces) of_room_[surface.content] = nullptr;
    parts_.loader->request(surfaces);
  }
  return true;
}

void FrameLoop::watch_room() {
  if (parts_.room == nullptr) return;
  std::optional<SurfaceUpdate> news = parts_.room->take();
  if (!news) return;
  for (const std::string& words : news->words) say(words);
  if (news->faults > 0) metrics_.faults["depth"] += news->faults;
  if (!news->surfaces) return;
  for (const Surface& surface : news->surfaces->surfaces)
    if (seen_in_room_.insert(surface.name).second) say("sees " + surface.name);
  for (Surface& surface : news->surfaces->surfaces)
    if (const auto content = parts_.room_contents.find(surface.name); content != parts_.room_contents.end())
      surface.content = content->second;
  parts_.room->shape_at(device::now_s() + options_.delay_s);  // contents are made from its heights
  show_of(*news->surfaces);
}

void FrameLoop::move_shape(double light_time) {
  if (parts_.room == nullptr) return;
  if (auto mesh = parts_.room->shape_at(light_time)) parts_.projection.set_mesh(kShapeName, std::move(mesh));
}

void FrameLoop::take_watch() {
  if (parts_.watch == nullptr) return;
  const std::optional<LightWatch::News> news = parts_.watch->take();
  if (!news) return;
  for (const std::string& sentence : news->sentences) say(sentence);
  if (news->status.faults > 0) metrics_.faults["watch"] = news->status.faults;
  metrics_.watch = news->status;
  if (pose_correction_) correct_pose(news->sights);
  if (news->target)
    glide_.emplace(parts_.projection.rig_from_projector(), news->target->rig_from_projector,
                   news->target->error, device::now_s());
  for (const LightWatch::MovedSurface& moved : news->surfaces) {
    const Projection& projection = parts_.projection;
    const Pose projector_from_world = projection.solved().projector_from_world.value_or(Pose());
    surface_glides_.begin(
        surfaces_now(), moved.name, moved.moved, moved.error,
        {projection.rig_from_projector(), projection.rig_from_projector() * projector_from_world},
        device::now_s());
  }
}

void FrameLoop::correct_pose(const std::vector<track::PoseSight>& sights) {
  if (const auto corrected = pose_correction_->add(sights)) take_pose(*corrected);
  const track::PoseCorrectionStatus found = pose_correction_->status();
  if (!sights.empty()) parts_.watch->tell(found);
  WatchStatus& status = *metrics_.watch;
  status.corrects_pose = true;
  status.pose_off_mm = 1e3 * found.error.segment<2>(3).norm();
  status.pose_off_deg = std::abs(found.error[2]) / kDegree;
  status.pose_sigma_mm = 1e3 * found.sigma.segment<2>(3).maxCoeff();
  status.pose_images = found.taken;
  status.pose_refused = found.refused;
}

void FrameLoop::move_projector(double now) {
  if (!glide_) return;
  const Pose rig_from_projector = glide_->at(now);
  if (glide_->is_over(now)) glide_.reset();
  guarded("watch", [&] { parts_.projection.move_projector(rig_from_projector); });
  ++placed_;
  record(MovedProjector{parts_.projection.rig_from_projector()});
}

void FrameLoop::move_surfaces(double now) {
  if (surface_glides_.is_idle()) return;
  SurfaceSet moved = surfaces_now();
  surface_glides_.apply(moved, now);
  if (show_of(moved) && parts_.editor != nullptr && surface_glides_.is_idle())
    parts_.editor->replace(std::move(moved), false);
}

}  // namespace procam::show
