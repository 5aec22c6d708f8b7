/// The blend of a running show with other projectors: whose light there is, and when this one's share of it changes.
#include <algorithm>

#include "frame_loop.hpp"
#include "name_list.hpp"

namespace procam::show {
namespace {

/// From the announcement of a projector to its first light, seconds: in it the others make their maps, which take about as
/// long as this one's.
double notice(double own_map) {
  constexpr double kMinNotice = 1.0, kMaxNotice = 15.0;
  return std::min(kMaxNotice, kMinNotice + 1.5 * own_map);
}

}  // namespace

BlendScene FrameLoop::blend_scene(ProjectorNames projectors) const {
  return {std::move(projectors), parts_.projection.rig_from_projector(), parts_.projection.show().surfaces};
}

void FrameLoop::begin_blend() {
  if (parts_.blend == nullptr) return;
  metrics_.blend.emplace();
  // In a group nobody knows yet which others have light.
  const ProjectorNames first = parts_.group != nullptr ? ProjectorNames() : parts_.blend->plan().fixed;
  use_blend(parts_.blend->make_now(blend_scene(first)));
  if (parts_.sides != nullptr) parts_.sides->begin_blend(first);
  if (parts_.group != nullptr) return;
  blend_version_ = placed_;  // that map is not made again
  blend_sets_ = {first};
}

/// The projectors of this process.
ProjectorNames FrameLoop::own_projectors() const {
  ProjectorNames own = {parts_.blend->plan().projector};
  for (std::size_t i = 0; parts_.sides != nullptr && i < parts_.sides->size(); ++i)
    own.push_back(parts_.sides->at(i).name);
  return own;
}

BlendTurn FrameLoop::turn_of_blend(double light_time) {
  const BlendPlan& plan = parts_.blend->plan();
  if (parts_.group == nullptr) {
    BlendTurn turn;
    turn.now = turn.announced = plan.fixed;
    return turn;
  }
  const ProjectorNames own = own_projectors();
  std::vector<dds::GroupLight> others = parts_.group->lights();
  others.erase(std::remove_if(others.begin(), others.end(),
                              [&](const dds::GroupLight& other) {
                                return std::find(own.begin(), own.end(), other.projector) != own.end() ||
                                       std::none_of(plan.rig.projectors.begin(), plan.rig.projectors.end(),
                                                    [&](const RigProjector& known) {
                                                      return known.name == other.projector;
                                                    });
                              }),
               others.end());
  return blend_turn(own, lit_from_, others, parts_.group->group_time(light_time));
}

void FrameLoop::follow_blend(double now) {
  if (parts_.blend == nullptr) return;
  BlendMaker& maker = *parts_.blend;
  const BlendTurn turn = turn_of_blend(now + options_.delay_s);
  std::vector<ProjectorNames> sets = {turn.now};
  sets.insert(sets.end(), turn.next.begin(), turn.next.end());
  if (placed_ != blend_version_ || sets != blend_sets_) {
    if (placed_ != blend_version_ || (!blend_sets_.empty() && sets.front() != blend_sets_.front()))
      blend_changed_ = now;
    blend_version_ = placed_;
    blend_sets_ = sets;
    if (parts_.sides != nullptr) parts_.sides->want_blend(placed_, sets);
    maker.want(placed_, blend_scene({}), std::move(sets));
  }
  if (const auto fault = maker.take_fault()) count_fault("blend", *fault + "; the blend from before stays");
  const auto is_ready = [&](const ProjectorNames& set) {
    return maker.is_ready(set) && (parts_.sides == nullptr || parts_.sides->is_blend_ready(set));
  };
  if (parts_.group != nullptr && !lit_from_ && is_ready(turn.announced)) {
    lit_from_ = parts_.group->group_time(now) +
                (parts_.group->metrics().hosts > 1 ? notice(now - blend_changed_) : 0);
    parts_.group->light(*lit_from_);
  }
  if (turn.is_dark) return;
  // Screens change in one frame, so that places of both are neither too dark nor too bright meanwhile.
  if (parts_.sides != nullptr && !is_ready(turn.now)) return;
  if (const auto made = maker.find(turn.now); made && made != blend_) {
    metrics_.blend->last_change_s = now - blend_changed_;
    if (parts_.sides != nullptr) parts_.sides->use_blend(turn.now);
    use_blend(made);
  }
}

void FrameLoop::use_blend(const std::shared_ptr<const MadeBlend>& made) {
  parts_.projection.set_blend(made->blend);
  record(made->scene);
  draws_frozen_ = draws_frozen_ || frozen_;
  BlendMetrics& metrics = *metrics_.blend;
  metrics.is_dark = made->scene.projectors.empty();
  ++metrics.changes;
  const bool is_first = blend_ == nullptr;
  blend_ = made;
  if (!is_first && made->scene.projectors == metrics.projectors) return;
  metrics.projectors = made->scene.projectors;
  ProjectorNames others = metrics.projectors;
  others.erase(std::remove(others.begin(), others.end(), parts_.blend->plan().projector), others.end());
  if (metrics.is_dark)
    say("dark until this projector has its turn in the blend");
  else
    say(others.empty() ? "no other projector has light: no blend" : "blended with " + joined(others));
  for (const Diagnostic& one : made->diagnostics.items)
    if (one.code == "stays_dark") say(one.message);
}

}  // namespace procam::show
