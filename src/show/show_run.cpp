#include "show_run.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "depth_surfaces.hpp"
#include "procam/dds/security.hpp"
#include "procam/device/frame_source.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/io/text.hpp"
#include "procam/render/cpu.hpp"
#include "procam/session/capture.hpp"
#include "run_inputs.hpp"
#include "run_options.hpp"

namespace procam::show {
namespace {

/// Those of the first screen. Throws as check_combination() does.
ShowOptions checked(const ShowOptions& options) {
  check_combination(options);
  return of_first_screen(options);
}

void require_size(const device::FrameSink& sink, const Projection& projection) {
  require(sink.size() == projection.frame_size(), "show::run: a sink of another size than the projector's");
}

}  // namespace

ShowRun::ShowRun(const Rig& rig, bool is_calibrated, const ShowOptions& options, ShowListener& listener,
                 std::vector<device::FrameSink*> sinks)
    : rig_(rig),
      is_calibrated_(is_calibrated),
      options_(checked(options)),
      listener_(listener),
      given_sinks_(std::move(sinks)),
      in_room_(is_depth_source(options.surfaces)),
      folder_(content_folder(options.surfaces)),
      silhouettes_([this](const std::string& sentence) { listener_.on_event(sentence); }) {
  if (!options_.dds_security.empty()) dds::use_security(options_.dds_security);
  ProjectionOptions projection = projection_options(options_, rig);
  if (projection.renderer->device() != "cpu") listener_.on_start("drawn by " + projection.renderer->device());
  conditions_ = conditions_text(options_, projection, rig);
  if (options_.people)
    people_ =
        std::make_unique<ShowPeople>(*options_.people, rig, rig.projector(options_.projector),
                                     [this](const std::string& sentence) { listener_.on_event(sentence); });
  if (people_ || options_.depth.silhouettes)
    projection.over = [this](const Projection& through, double light_time, ImageView<std::uint8_t> frame) {
      if (people_) people_->draw_over(through, light_time, frame);
      if (options_.depth.silhouettes) silhouettes_.add(room_->darken(frame, through, light_time));
    };
  if (in_room_) room_ = watch_room(options_, rig, projection);
  if (!options_.publish.empty()) {
    std::optional<Pose> world_from_rig;
    if (projection.projector_from_world)
      world_from_rig =
          (rig.projector(options_.projector).rig_from_projector * *projection.projector_from_world).inverse();
    graph_ = std::make_unique<Ros2Output>(options_, rig, projection.child_from_rig, world_from_rig);
  }
  moving_ = projection.moving;
  if (options_.watch && options_.watch->pose_m > 0)
    loop_.pose_correction = pose_correction(options_, projection);
  projection_ = std::make_unique<Projection>(rig, projection);
  load_surfaces();
  if (auto plan = plan_blend(options_, rig, projection, first_)) open_blend(std::move(*plan));
  if (!options_.group.empty()) open_group();
  open_output();
  if (!options_.screens.empty()) open_sides(projection);
  if (!options_.fleet.empty()) open_fleet();
  open_inputs();
  if (link_) link_->wait_until_joined([this] { listener_.on_frame({}); });
}

ShowReport ShowRun::run() {
  LoopParts parts{*projection_, *sink_};
  for (const auto& source : sources_) parts.sources.push_back(source.get());
  for (const std::string& text : options_.poses)
    parts.source_names += (parts.source_names.empty() ? "" : ", ") + text;
  if (link_ && parts.source_names.empty()) parts.source_names = "group " + options_.group;
  if (options_.marker) parts.source_names = "the markers before camera " + options_.marker->camera;
  std::optional<Editor> editor;
  if (!in_room_) parts.editor = &editor.emplace(first_);
  parts.loader = loader_.get();
  parts.room = room_.get();
  if (in_room_) parts.room_contents = absolute_contents(options_);
  parts.watch = watch_.get();
  parts.graph = graph_.get();
  parts.sights = sights_.get();
  parts.page = page_.get();
  parts.group = link_.get();
  parts.fleet = fleet_.get();
  parts.blend = blend_.get();
  parts.sides = sides_.get();
  parts.screen = options_.projector;
  parts.recorder = recorder_ ? &*recorder_ : nullptr;
  parts.contents = content_choices(folder_, first_);
  parts.other_faults = [this](std::map<std::string, std::uint64_t>& faults) {
    count_people_faults(faults);
    if (group_faults_ > 0) faults["group_pose"] = group_faults_;
    if (publish_faults_ > 0) faults["ros2_publish"] = publish_faults_;
    for (const auto& [cause, count] : rejected()) faults[cause] = count;
  };
  parts.commands = [this] { return listener_.commands(); };
  parts.say = [this](const std::string& sentence) { listener_.on_event(sentence); };
  parts.tick = [this](const Metrics& metrics) {
    take_people();
    publish(metrics);
    listener_.on_frame(report(metrics));
  };
  try {
    const Metrics metrics = run_loop(parts, loop_);
    finish_outputs();
    return report(metrics);
  } catch (...) {  // a listener that ends the show, or an output that broke: a video is kept all the same
    finish_outputs();
    throw;
  }
}

void ShowRun::finish_outputs() {
  sink_->finish();
  for (const auto& side : side_screens_) side->sink->finish();
}

void ShowRun::take_people() {
  if (!people_) return;
  try {
    people_->take(*projection_);
  } catch (const std::exception& error) {
    if (people_faults_++ == 0) listener_.on_event(error.what());
  }
}

void ShowRun::publish(const Metrics& metrics) {
  if (!graph_) return;
  try {
    graph_->publish(*projection_, metrics);
  } catch (const std::exception& error) {
    if (publish_faults_++ == 0) listener_.on_event(error.what());
  }
}

void ShowRun::publish_pose(const track::StampedPose& message) {
  if (!graph_) return;
  try {
    graph_->publish_pose(message, options_.source_delay_s);
  } catch (const std::exception& error) {
    if (publish_faults_++ == 0) listener_.on_event(error.what());
  }
}

Rejected ShowRun::rejected() {
  Rejected sum;
  for (const auto& source : sources_) add_to(sum, source->rejected());
  if (room_) add_to(sum, room_->rejected());
  if (watch_) add_to(sum, watch_->rejected());
  if (sights_) add_to(sum, sights_->rejected());
  // Contents come and go; what those that went have rejected stays counted.
  for (const auto& content : projection_->show().contents) {
    const Rejected now = content ? content->rejected() : Rejected();
    if (now.empty()) continue;
    Rejected& known = by_content_[content.get()];
    for (const auto& [cause, count] : now)
      rejected_by_contents_[cause] += count >= known[cause] ? count - known[cause] : count;
    known = now;
  }
  add_to(sum, rejected_by_contents_);
  return sum;
}

void ShowRun::count_people_faults(std::map<std::string, std::uint64_t>& faults) const {
  if (!people_) return;
  const PeopleCounts counts = people_->counts();
  const std::pair<const char*, std::uint64_t> by_name[] = {{"people", people_faults_},
                                                           {"people_malformed", counts.malformed},
                                                           {"people_refused", counts.refused},
                                                           {"people_repeated", counts.repeated},
                                                           {"people_teleports", counts.teleports}};
  for (const auto& [name, count] : by_name)
    if (count > 0) faults[name] = count;
}

ShowReport ShowRun::report(const Metrics& metrics) const {
  ShowReport report;
  report.metrics = metrics;
  report.poses = projection_->track().faults();
  if (people_) report.people = people_->counts();
  return report;
}

void ShowRun::load_surfaces() {
  ShowLoaderOptions loading;
  if (!in_room_) {
    loading.surfaces = options_.surfaces;
    loading.contents = absolute_contents(options_);
  }
  loading.folder = folder_;
  loading.pixels_only = !is_calibrated_;
  // A frame of a run that is to be shown again waits for its picture.
  loading.pace = options_.record.empty() ? device::Pace::kLive : device::Pace::kExact;
  first_ = show::load_surfaces(loading);  // throws what is wrong with it
  loader_ = std::make_unique<ShowLoader>(loading);
  LoadedShow loaded = loader_->load_now([this](int done, int total) { listener_.on_load(done, total); });
  for (const std::string& fault : loaded.faults) listener_.on_event(fault);
  if (!loaded.show)
    throw Error(ErrorKind::kInput, options_.surfaces, "it changed while it was read", "start again");
  projection_->set_show(std::move(*loaded.show));
}

void ShowRun::open_blend(BlendPlan plan) {
  if (has_moving_surfaces(plan, first_))
    listener_.on_start("surfaces in the world are not blended while the rig moves");
  blend_ = std::make_unique<BlendMaker>(std::move(plan));
}

void ShowRun::open_group() {
  dds::GroupOptions group;
  group.name = options_.group;
  group.strength = options_.group_strength;
  if (blend_) group.projectors = {blend_->plan().projector};
  for (std::size_t i = 1; blend_ && i < options_.screens.size(); ++i)
    group.projectors.push_back(options_.screens[i].projector);
  link_ = std::make_unique<GroupLink>(group, options_.surfaces);
  listener_.on_start(link_->description());
}

void ShowRun::open_fleet() {
  // A grant is seen at the begin of the next frame.
  fleet_ = std::make_unique<FleetLink>(options_, loop_.delay_s + (loop_.fps > 0 ? 1 / loop_.fps : 0));
  listener_.on_start(fleet_->description());
}

void ShowRun::share_pose(const track::StampedPose& message) {
  if (!link_) return;
  try {
    link_->publish_pose(message);
  } catch (const std::exception& error) {
    if (group_faults_++ == 0) listener_.on_event(error.what());
  }
}

void ShowRun::open_output() {
  loop_.fps = options_.fps > 0 ? options_.fps : kUsualRate;
  loop_.duration_s = options_.duration_s;
  loop_.autosave = options_.autosave;
  if (given_sinks_.empty()) {
    opened_sink_ = open_screen(options_.display, options_.output, projection_->frame_size());
    sink_ = opened_sink_.get();
  } else {
    sink_ = given_sinks_.front();
    require_size(*sink_, *projection_);
  }
  loop_.delay_s = options_.delay_camera.empty() ? options_.delay_s : measured_delay();
}

std::unique_ptr<device::FrameSink> ShowRun::open_screen(const std::optional<std::string>& display,
                                                        const std::string& output, ImageSize size) {
  if (output.empty()) return open_display(display, size);
  device::SinkOptions sink;
  sink.size = size;
  sink.fps = loop_.fps;
  return device::open_sink(output, sink);
}

void ShowRun::open_sides(const ProjectionOptions& first) {
  std::vector<SideScreen> screens;
  for (std::size_t i = 1; i < options_.screens.size(); ++i) {
    const ScreenOutput& output = options_.screens[i];
    const ProjectionOptions projection = of_side_screen(first, options_, rig_, output.projector);
    Side& side = *side_screens_.emplace_back(std::make_unique<Side>());
    side.projection = std::make_unique<Projection>(rig_, projection);
    if (auto plan = plan_blend(options_, rig_, projection, first_))
      side.blend = std::make_unique<BlendMaker>(std::move(*plan));
    if (given_sinks_.empty()) {
      const double fps = loop_.fps;
      side.opened = open_screen(output.display, output.output, side.projection->frame_size());
      loop_.fps = fps;
      side.sink = side.opened.get();
    } else {
      side.sink = given_sinks_.at(i);
      require_size(*side.sink, *side.projection);
    }
    screens.push_back({output.projector, *side.projection, *side.sink, side.blend.get()});
  }
  sides_ = std::make_unique<SideScreens>(*projection_, std::move(screens));
}

std::unique_ptr<device::FrameSink> ShowRun::open_display(const std::optional<std::string>& wanted,
                                                         ImageSize size) {
  const std::vector<device::Display> list = device::displays();
  const device::Display& display = device::choose_display(list, wanted);
  if (!(display.size == size))
    throw Error(ErrorKind::kDevice, "display " + std::to_string(display.number),
                "it shows " + io::format_size(display.size) + " and the projector was calibrated with " +
                    io::format_size(size),
                "set the display's mode to the projector's, or calibrate in this mode");
  auto window = device::open_window(display.number);
  if (options_.fps <= 0 && display.refresh_hz > 0) loop_.fps = display.refresh_hz;
  listener_.on_start("display " + std::to_string(display.number) + ": " + display.name + ", " +
                     io::format_size(display.size));
  return window;
}

double ShowRun::measured_delay() {
  const auto camera = device::open_camera(options_.delay_camera);
  const session::Delay delay = session::measure_delay({*sink_, *camera, [this] { listener_.on_frame({}); }});
  const double light = std::max(0.0, delay.delay_s - options_.camera_delay_s);
  char sentence[200];
  std::snprintf(sentence, sizeof sentence,
                "delay from the window to the light: %.1f ms (the camera saw it after %.1f ms; %.1f ms of "
                "them are taken for its own)",
                1e3 * light, 1e3 * delay.delay_s, 1e3 * options_.camera_delay_s);
  listener_.on_start(sentence);
  return light;
}

void ShowRun::open_inputs() {
  for (const std::string& text : options_.poses) {
    sources_.push_back(open_poses(options_, text));
    tell_opened(*sources_.back());
    if (link_)
      sources_.back() = std::make_unique<HeardPoses>(
          std::move(sources_.back()), [this](const track::StampedPose& message) { share_pose(message); });
  }
  if (options_.marker)
    sources_.push_back(std::make_unique<HeardPoses>(open_markers(*options_.marker, rig_),
                                                    [this](const track::StampedPose& message) {
                                                      publish_pose(message);
                                                      share_pose(message);
                                                    }));
  if (options_.marker) tell_opened(*sources_.back());
  if (link_ && sources_.empty() && options_.pose.empty()) sources_.push_back(link_->pose_source());
  if (room_) tell_opened(*room_);
  if (graph_) {
    publish({});
    listener_.on_start(graph_->description());
  }
  if (options_.watch) {
    watch_ = watch_light(options_, rig_, sources_.empty() && !in_room_);
    tell_opened(*watch_);
  }
  if (options_.track) {
    sights_ = open_sights(options_, rig_, moving_, projection_->solved());
    tell_opened(*sights_);
  }
  if (!options_.record.empty()) {
    recorder_.emplace(options_.record, conditions_);
    // A recorded run begins from what its log holds, digit by digit.
    Show again = projection_->show();
    again.surfaces = io::surfaces_from_text(io::surfaces_to_text(again.surfaces), options_.surfaces);
    projection_->set_show(std::move(again));
  }
  if (options_.control != "off") {
    page_ = std::make_unique<ControlPage>(control_options(options_));
    listener_.on_start("control page: " + page_->url());
  }
}

}  // namespace procam::show
