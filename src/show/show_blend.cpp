#include "show_blend.hpp"

#include <algorithm>
#include <utility>

#include "name_list.hpp"
#include "procam/surface/solve.hpp"
#include "thread_share.hpp"

namespace procam::show {
namespace {

[[noreturn]] void refuse_blend(const std::string& what, const std::string& why, const std::string& next) {
  throw Error(ErrorKind::kInput, what, why, next);
}

void require_in_rig(const Rig& rig, const std::string& what, const std::string& name) {
  std::vector<std::string> names;
  for (const RigProjector& projector : rig.projectors) names.push_back(projector.name);
  if (std::find(names.begin(), names.end(), name) == names.end())
    refuse_blend(what, "the rig has no projector '" + name + "'", "name one of: " + joined(names, ", "));
}

void add_name(ProjectorNames& names, const std::string& name) {
  const auto at = std::lower_bound(names.begin(), names.end(), name);
  if (at == names.end() || *at != name) names.insert(at, name);
}

ProjectorNames without(ProjectorNames names, const std::string& name) {
  names.erase(std::remove(names.begin(), names.end(), name), names.end());
  return names;
}

/// Black and brightness are brought to a level of all places, also of those that this projector does not light.
bool has_level(const BlendPlan& plan) {
  return plan.settings.compensate > 0 || std::any_of(plan.settings.black.begin(), plan.settings.black.end(),
                                                     [](const auto& item) { return item.second > 0; });
}

bool is_in_frame(const Surface& surface, const char* frame) {
  const InRoom* place = place_of(surface.geometry);
  return place != nullptr && place->frame == frame;
}

/// Those that light of the projector can blend on.
SurfaceSet blended_surfaces(const BlendPlan& plan, const SurfaceSet& surfaces, bool is_own) {
  SurfaceSet kept;
  for (const Surface& surface : surfaces.surfaces) {
    if (!plan.rig_from_world && is_in_frame(surface, "world")) continue;
    const bool is_of_one = place_of(surface.geometry) == nullptr || is_in_frame(surface, "projector");
    if (is_own || !is_of_one) kept.surfaces.push_back(surface);
  }
  return kept;
}

double number_for(const std::map<std::string, double>& numbers, const std::string& name, double usual) {
  const auto found = numbers.find(name);
  return found == numbers.end() ? usual : found->second;
}

surface::BlendOptions blend_options(const BlendPlan& plan, std::size_t own) {
  surface::BlendOptions options;
  options.compensate = plan.settings.compensate > 0;
  if (options.compensate) options.min_gain = plan.settings.compensate;
  options.one_level = plan.settings.one_level;
  options.only = own;
  options.threads = plan.threads;
  return options;
}

}  // namespace

BlendPlan blend_basis(const ShowOptions& options, const Rig& rig, const ProjectionOptions& projection) {
  BlendPlan plan;
  plan.rig = rig;
  plan.projector = projection.projector;
  if (projection.projector_from_world)
    plan.rig_from_world =
        rig.projector(projection.projector).rig_from_projector * *projection.projector_from_world;
  if (options.blend) plan.settings = *options.blend;
  plan.threads = options.threads;
  return plan;
}

std::optional<BlendPlan> plan_blend(const ShowOptions& options, const Rig& rig,
                                    const ProjectionOptions& projection, const SurfaceSet& surfaces) {
  const bool in_group = !options.group.empty();
  if (!options.blend && !in_group && options.screens.empty()) return std::nullopt;
  BlendPlan plan = blend_basis(options, rig, projection);
  if (plan.settings.projectors == std::vector<std::string>{"off"}) return std::nullopt;
  for (const auto& [name, ratio] : plan.settings.black) require_in_rig(rig, "black of '" + name + "'", name);
  for (const auto& [name, light] : plan.settings.brightness)
    require_in_rig(rig, "brightness of '" + name + "'", name);
  if (in_group) return rig.projectors.size() > 1 ? std::optional(std::move(plan)) : std::nullopt;
  add_name(plan.fixed, plan.projector);
  for (const ScreenOutput& screen : options.screens) add_name(plan.fixed, screen.projector);
  for (const std::string& name : plan.settings.projectors) {
    if (name == "all") {
      for (const RigProjector& projector : rig.projectors) add_name(plan.fixed, projector.name);
    } else {
      require_in_rig(rig, "blend with '" + name + "'", name);
      add_name(plan.fixed, name);
    }
  }
  if (plan.fixed.size() == 1)
    refuse_blend("blend", "it names no other projector than '" + plan.projector + "', which this show has",
                 "name the others of the rig, or all");
  if (has_moving_surfaces(plan, surfaces) && options.blend)
    refuse_blend(
        "blend",
        "surfaces are in the world and the rig moves: where projectors overlap on them changes in "
        "every frame",
        "give --pose for a rig that stands still, place the surfaces in the frame of the rig, or leave "
        "out --blend");
  return plan;
}

bool has_moving_surfaces(const BlendPlan& plan, const SurfaceSet& surfaces) {
  return !plan.rig_from_world &&
         std::any_of(surfaces.surfaces.begin(), surfaces.surfaces.end(),
                     [](const Surface& surface) { return is_in_frame(surface, "world"); });
}

MadeBlend make_blend(const BlendPlan& plan, BlendScene scene) {
  MadeBlend made;
  const Projector& own = plan.rig.projector(plan.projector).projector;
  if (scene.projectors.empty()) {
    made.blend = dark_blend(own.size());
  } else if (scene.projectors.size() > 1 || plan.settings.compensate > 0) {
    std::vector<SolvedSurfaceSet> sets;
    std::vector<surface::BlendInput> lit;
    sets.reserve(scene.projectors.size());
    std::size_t own_number = 0;
    surface::SolveOptions solving;
    solving.visibility = false;
    for (const std::string& name : scene.projectors) {
      RigProjector projector = plan.rig.projector(name);
      if (name == plan.projector) {
        projector.rig_from_projector = scene.rig_from_projector;
        own_number = sets.size();
      }
      std::optional<Pose> projector_from_world;
      if (plan.rig_from_world)
        projector_from_world = (projector.rig_from_projector.inverse() * *plan.rig_from_world).normalized();
      sets.push_back(surface::solve_surfaces(blended_surfaces(plan, scene.surfaces, name == plan.projector),
                                             projector, projector_from_world, solving));
      lit.push_back({projector.projector, &sets.back(), number_for(plan.settings.brightness, name, 1),
                     number_for(plan.settings.black, name, 0)});
    }
    surface::Blend blend = surface::blend_maps(lit, blend_options(plan, own_number));
    for (const std::size_t j : blend.neighbours[own_number]) made.neighbours.push_back(scene.projectors[j]);
    made.blend = std::make_shared<const surface::FrameBlend>(blend.maps[own_number]);
    made.diagnostics = std::move(blend.diagnostics);
  }
  made.scene = std::move(scene);
  return made;
}

BlendTurn blend_turn(const ProjectorNames& own, const std::optional<double>& own_from,
                     const std::vector<dds::GroupLight>& others, double light_time) {
  BlendTurn turn;
  turn.is_dark = !own_from || *own_from > light_time;
  std::vector<dds::GroupLight> later;
  for (const std::string& name : own) add_name(turn.now, name);
  for (const dds::GroupLight& other : others) {
    if (other.from <= light_time)
      add_name(turn.now, other.projector);
    else
      later.push_back(other);
  }
  std::sort(later.begin(), later.end(),
            [](const dds::GroupLight& a, const dds::GroupLight& b) { return a.from < b.from; });
  turn.announced = turn.now;
  std::vector<ProjectorNames> steps;
  for (const dds::GroupLight& other : later) {
    add_name(turn.announced, other.projector);
    steps.push_back(turn.announced);
  }
  // The last step stays; those before it last for moments.
  turn.next.assign(steps.rbegin(), steps.rend());
  // A host that fails takes all its projectors with it.
  std::map<std::uint64_t, ProjectorNames> by_member;
  for (const dds::GroupLight& other : others) by_member[other.member].push_back(other.projector);
  for (const auto& [member, names] : by_member) {
    ProjectorNames rest = turn.announced;
    for (const std::string& name : names)
      if (std::find(own.begin(), own.end(), name) == own.end()) rest = without(rest, name);
    if (std::find(turn.next.begin(), turn.next.end(), rest) == turn.next.end())
      turn.next.push_back(std::move(rest));
  }
  return turn;
}

BlendMaker::BlendMaker(BlendPlan plan) : plan_(std::move(plan)), thread_([this] { run(); }) {}

BlendMaker::~BlendMaker() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ends_ = true;
  }
  woken_.notify_one();
  thread_.join();
}

void BlendMaker::want(std::uint64_t version, const BlendScene& scene, std::vector<ProjectorNames> sets) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (version != version_) scene_ = scene;
    version_ = version;
    sets_ = std::move(sets);
    for (auto made = made_.begin(); made != made_.end();)
      made = std::find(sets_.begin(), sets_.end(), made->first) == sets_.end() ? made_.erase(made)
                                                                               : std::next(made);
  }
  woken_.notify_one();
}

bool BlendMaker::is_ready(const ProjectorNames& set) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = made_.find(set);
  return found != made_.end() && found->second.made && found->second.version == version_;
}

std::shared_ptr<const MadeBlend> BlendMaker::find(const ProjectorNames& set) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto found = made_.find(set);
  return found == made_.end() ? nullptr : found->second.made;
}

std::shared_ptr<const MadeBlend> BlendMaker::make_now(BlendScene scene) const {
  return std::make_shared<const MadeBlend>(make_blend(plan_, std::move(scene)));
}

std::optional<std::string> BlendMaker::take_fault() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return std::exchange(fault_, std::nullopt);
}

const ProjectorNames* BlendMaker::next_set() const {
  for (const ProjectorNames& set : sets_) {
    const auto found = made_.find(set);
    if (found == made_.end() || found->second.version != version_) return &set;
  }
  return nullptr;
}

void BlendMaker::keep(std::uint64_t version, const std::shared_ptr<const MadeBlend>& made) {
  const ProjectorNames& set = made->scene.projectors;
  if (std::find(sets_.begin(), sets_.end(), set) == sets_.end()) return;
  made_[set] = {version, made};
  if (has_level(plan_)) return;
  // Without one that lights no place of this projector, its map is the same.
  for (const std::string& name : set) {
    const ProjectorNames fewer = without(set, name);
    const bool matters =
        name == plan_.projector ||
        std::find(made->neighbours.begin(), made->neighbours.end(), name) != made->neighbours.end();
    if (matters || std::find(sets_.begin(), sets_.end(), fewer) == sets_.end()) continue;
    MadeBlend same = *made;
    same.scene.projectors = fewer;
    made_[fewer] = {version, std::make_shared<const MadeBlend>(std::move(same))};
  }
}

void BlendMaker::run() {
  let_the_show_go_first();
  std::unique_lock<std::mutex> lock(mutex_);
  while (!ends_) {
    const ProjectorNames* const set = next_set();
    if (set == nullptr) {
      woken_.wait(lock);
      continue;
    }
    BlendScene scene = scene_;
    scene.projectors = *set;
    const std::uint64_t version = version_;
    const ProjectorNames names = *set;
    lock.unlock();
    std::shared_ptr<const MadeBlend> made;
    std::string fault;
    try {
      made = make_now(std::move(scene));
    } catch (const std::exception& error) {
      fault = error.what();
    }
    lock.lock();
    if (made) {
      keep(version, made);
    } else {
      made_[names].version = version;  // the map from before stays
      fault_ = fault;
    }
  }
}

std::shared_ptr<const surface::FrameBlend> dark_blend(ImageSize size) {
  return std::make_shared<const surface::FrameBlend>(
      surface::BlendMap{ImageF(size), ImageF(size), ImageF(size)});
}

}  // namespace procam::show
