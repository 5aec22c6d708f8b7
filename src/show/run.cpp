#include "procam/show/run.hpp"

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <thread>
#include <tuple>

#include "depth_surfaces.hpp"
#include "group_link.hpp"
#include "height_content.hpp"
#include "loop.hpp"
#include "marker_source.hpp"
#include "overlay.hpp"
#include "procam/core/base/words.hpp"
#include "procam/core/rig/room_frames.hpp"
#include "procam/dds/pose_source.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/device/frame_source.hpp"
#include "procam/io/files.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/io/text.hpp"
#include "procam/render/cpu.hpp"
#include "procam/render/gl.hpp"
#include "procam/session/capture.hpp"
#include "rejected_counts.hpp"
#include "ros2_output.hpp"
#include "show_people.hpp"
#include "uncalibrated.hpp"

namespace procam::show {
namespace {

namespace fs = std::filesystem;

constexpr double kUsualRate = 60;  // frames a second

std::shared_ptr<render::Renderer> renderer_for(const ShowOptions& options) {
  render::RenderOptions rendering;
  rendering.threads = options.threads;
  rendering.filter = options.bilinear ? render::Filter::kBilinear : render::Filter::kArea;
  rendering.linear_light = !options.average_numbers;
  return render_gl::open_renderer(options.renderer, rendering);
}

Pose load_mount(const std::string& file, const Rig& rig, const RigProjector& projector) {
  FrameTree::Link mount = io::load_pose(file);
  if (mount.target != "base" && mount.source != "base")
    throw Error(ErrorKind::kInput, file, "it does not tell where anything is on 'base'",
                "give a pose between 'base' and the rig, its projector or a camera");
  // room_frames() attaches a device's surroundings to the rig under the name "world".
  (mount.target == "base" ? mount.target : mount.source) = "world";
  return room_frames(rig, projector, std::move(mount)).get("world", "rig").pose;
}

/// Without poses the rig stands still; surfaces of a depth camera are then in its own frame.
bool rig_is_world(const ShowOptions& options) {
  return is_depth_source(options.surfaces) && options.poses.empty() && !options.marker &&
         options.pose.empty();
}

ProjectionOptions projection_options(const ShowOptions& options, const Rig& rig) {
  const RigProjector& projector = rig.projector(options.projector);
  ProjectionOptions projection;
  projection.projector = projector.name;
  if (!options.pose.empty())
    projection.projector_from_world =
        room_frames(rig, projector, io::load_pose(options.pose)).get(projector.name, "world").pose;
  if (rig_is_world(options)) projection.projector_from_world = projector.rig_from_projector.inverse();
  if (!options.mount.empty()) projection.child_from_rig = load_mount(options.mount, rig, projector);
  projection.track.frame = options.frame;
  projection.track.child = options.child;
  projection.track.prediction = track::parse_prediction(options.prediction);
  projection.track.delay = options.source_delay_s;
  if (options.blank_on_stale_s) projection.track.stale_after = *options.blank_on_stale_s;
  if (options.freeze_on_stale_s) projection.track.stale_after = *options.freeze_on_stale_s;
  projection.blank_on_stale = options.blank_on_stale_s.has_value();
  projection.marks = options.watch && options.watch->marks;
  projection.renderer = renderer_for(options);
  return projection;
}

/// 64 bits of the rig's devices.
std::uint64_t rig_fingerprint(const Rig& rig) {
  std::string text;
  const auto add = [&](const std::string& name, const Camera& camera, const Pose& pose) {
    const Intrinsics& k = camera.intrinsics;
    std::vector<double> numbers = {
        k.fx, k.fy, k.cx, k.cy, k.skew, double(camera.size.width), double(camera.size.height)};
    for (const double coefficient : coefficients_of(camera.distortion)) numbers.push_back(coefficient);
    const Mat4 matrix = pose.matrix();
    numbers.insert(numbers.end(), matrix.data(), matrix.data() + 16);
    text += name;
    for (const double number : numbers) {
      char digits[40];
      std::snprintf(digits, sizeof digits, " %.17g", number);
      text += digits;
    }
  };
  for (const RigCamera& camera : rig.cameras) add(camera.name, camera.camera, camera.rig_from_camera);
  for (const RigProjector& one : rig.projectors)
    add(one.name, one.projector.inverse_camera, one.rig_from_projector);
  return fingerprint(ViewU8(reinterpret_cast<const std::uint8_t*>(text.data()), int(text.size()), 1, 1));
}

/// What frames depend on besides what a log holds.
std::string conditions_text(const ShowOptions& options, const ProjectionOptions& projection, const Rig& rig) {
  char text[512];
  std::snprintf(text, sizeof text,
                "projector %s, predict %s, source delay %g s, stale %g s%s, %s%s%s by %s, rig %016" PRIx64,
                projection.projector.c_str(), options.prediction.c_str(), options.source_delay_s,
                projection.track.stale_after, projection.blank_on_stale ? " to black" : "",
                options.bilinear ? "bilinear" : "area", options.average_numbers ? " of numbers" : "",
                projection.marks ? " with marks" : "", projection.renderer->device().c_str(),
                rig_fingerprint(rig));
  const auto of_file = [](const char* name, const std::string& file) {
    return file.empty() ? "" : std::string(", ") + name + " " + io::sha256_of_file(file).substr(0, 16);
  };
  return text + of_file("pose", options.pose) + of_file("mount", options.mount);
}

/// The folder that contents are relative to.
fs::path content_folder(const std::string& surfaces) {
  return surfaces.empty() || is_depth_source(surfaces) ? fs::current_path()
                                                       : fs::absolute(surfaces).parent_path();
}

/// Contents of the options are relative to the working directory, those of a surface file to its folder.
std::map<std::string, std::string> absolute_contents(const ShowOptions& options) {
  std::map<std::string, std::string> contents = options.contents;
  for (auto& item : contents)
    item.second = device::content_beside(fs::current_path() / "show.json", item.second);
  return contents;
}

/// What may be chosen as content at the control page.
std::vector<std::string> content_choices(const fs::path& folder, const SurfaceSet& set) {
  std::vector<std::string> found = device::content_files(folder, 200);
  for (const Surface& surface : set.surfaces)
    if (!surface.content.empty() && std::find(found.begin(), found.end(), surface.content) == found.end())
      found.push_back(surface.content);
  for (const char* colour : {"#ffffff", "#ff0000", "#00ff00", "#0000ff"}) found.emplace_back(colour);
  return found;
}

/// The region of a shape, which the camera must have.
std::optional<depth::PixelRegion> shape_region(const DepthSurfaces& named, const RigCamera& camera) {
  if (!named.region) return std::nullopt;
  const depth::PixelRegion& r = *named.region;
  const ImageSize size = camera.camera.size;
  if (r.width < 8 || r.height < 8 || r.x + r.width > size.width || r.y + r.height > size.height || r.x < 0 ||
      r.y < 0)
    throw Error(ErrorKind::kInput,
                "region of " + std::to_string(r.width) + "x" + std::to_string(r.height) + " pixels",
                "it is smaller than 8x8 pixels, or not inside of the " + io::format_size(size) +
                    " pixels of camera '" + camera.name + "'",
                "give region=X:Y:WIDTHxHEIGHT inside of the depth image");
  return r;
}

std::unique_ptr<DepthSurfaceSource> watch_room(const ShowOptions& options, const Rig& rig,
                                               const ProjectionOptions& projection) {
  const DepthInput& depth = options.depth;
  DepthSurfaceSourceOptions watch;
  watch.room.camera = rig.camera(depth.camera);
  watch.room.metres_per_unit = depth.metres_per_unit;
  watch.room.delay = depth.delay_s;
  watch.room.track = projection.track;
  watch.room.child_from_rig = projection.child_from_rig;
  if (projection.projector_from_world)
    watch.room.world_from_rig =
        (rig.projector(projection.projector).rig_from_projector * *projection.projector_from_world).inverse();
  watch.room.map.up_in_world = depth.up.value_or(rig_is_world(options) ? Vec3(0, -1, 0) : Vec3(0, 0, 1));
  if (depth.silhouettes)
    watch.room.silhouettes =
        is_shape_source(options.surfaces) ? shape_silhouettes() : people::SilhouetteOptions();
  // The loss of the camera is handled as that of the poses.
  watch.lost_after = projection.track.stale_after;
  watch.blank_on_loss = projection.blank_on_stale;
  const DepthSurfaces named = parse_depth_surfaces(options.surfaces);
  if (named.is_shape) watch.room.shape.emplace().region = shape_region(named, watch.room.camera);
  device::DepthOptions opening;
  opening.size = watch.room.camera.camera.size;
  return std::make_unique<DepthSurfaceSource>(
      [source = named.source, opening] { return device::open_depth(source, opening); }, watch);
}

std::unique_ptr<track::PoseSource> open_markers(const MarkerInput& input, const Rig& rig) {
  if (input.marker.empty() && input.markers.empty())
    throw Error(ErrorKind::kInput, "marker camera", "no marker is named", "give a marker or a marker map");
  const MarkerMap map =
      input.marker.empty() ? io::load_marker_map(input.markers) : io::parse_marker(input.marker);
  const RigCamera& camera = rig.camera(input.name);
  device::CameraOptions options;
  options.size = camera.camera.size;
  const auto open = [name = input.camera, options] { return device::open_camera(name, options); };
  return std::make_unique<MarkerSource>(open(), camera, map, detect::marker_cells(map.dictionary), open);
}

/// `stands`: the rig stays where it is in the room, and its surfaces come from a file.
std::unique_ptr<LightWatch> watch_light(const ShowOptions& options, const Rig& rig, bool stands) {
  const WatchInput& input = *options.watch;
  LightWatchOptions watching;
  watching.camera = rig.camera(input.name);
  watching.projector = rig.projector(options.projector);
  watching.camera_delay = input.delay_s;
  watching.corrects = !input.only;
  watching.correction.surfaces = stands;
  watching.rig = rig;
  watching.save = input.save;
  watching.watch.movement.projector_covariance =
      watch::projector_covariance(rig, watching.projector.name, watching.camera.name);
  if (!options.record.empty())
    watching.log = (fs::absolute(options.record).parent_path() / "watch.csv").string();
  device::CameraOptions opening;
  opening.size = watching.camera.camera.size;
  return std::make_unique<LightWatch>(
      [name = input.camera, opening] { return device::open_camera(name, opening); }, watching);
}

ControlOptions control_options(const ShowOptions& options) {
  ControlOptions control = parse_page_address(options.control);
  control.token = options.token;
  return control;
}

/// The poses of a source, each of which is also told to somebody.
class HeardPoses : public track::PoseSource {
 public:
  using Hear = std::function<void(const track::StampedPose&)>;
  HeardPoses(std::unique_ptr<track::PoseSource> source, Hear hear)
      : source_(std::move(source)), hear_(std::move(hear)) {}
  void poll(std::vector<track::StampedPose>& arrived) override {
    source_->poll(arrived);
    for (const track::StampedPose& message : arrived) hear_(message);
  }
  track::SourceStatus status() const override { return source_->status(); }
  std::map<std::string, std::uint64_t> rejected() const override { return source_->rejected(); }
  std::string description() const override { return source_->description(); }

 private:
  std::unique_ptr<track::PoseSource> source_;
  Hear hear_;
};

/// What a run that is recorded, or has no depth camera, cannot have.
void check_combination(const ShowOptions& options) {
  const auto refuse = [](const std::string& what, const std::string& why, const std::string& next) {
    throw Error(ErrorKind::kInput, what, why, next);
  };
  if (options.surfaces.empty()) refuse("surfaces", "none are given", "name a surface file");
  if (options.people && !options.record.empty())
    refuse("record", "a run with people cannot be shown again bit for bit", "leave one of them out");
  if (options.watch && options.watch->only && !options.watch->save.empty())
    refuse("watch", "nothing is corrected that could be saved", "leave out --watch-only or --watch-save");
  if (options.watch && !options.watch->save.empty()) io::require_writable(options.watch->save);
  if (options.depth.silhouettes && !is_depth_source(options.surfaces))
    refuse("silhouettes", "no depth camera sees the room", "give surfaces depth:SOURCE");
  if (is_shape_source(options.surfaces) && !options.record.empty())
    refuse("record", "a run with a live shape cannot be shown again bit for bit", "leave one of them out");
  if (is_shape_source(options.surfaces) && options.watch)
    refuse("watch", "light on a surface that moves does not show whether the projector has",
           "leave out --watch");
  for (const auto& [surface, content] : options.contents)
    if (is_height_content(content)) {
      parse_height_content(content);
      if (!is_shape_source(options.surfaces))
        refuse("content '" + content + "' of '" + surface + "'",
               "there is no live shape whose heights it could show", "give surfaces depth-shape:SOURCE");
    }
  if (!options.group.empty() && is_depth_source(options.surfaces))
    refuse("group", "surfaces of a depth camera are not sent to other hosts",
           "leave out --group, or detect the surfaces before the show (detect-surfaces)");
  if (!options.group.empty() && options.watch)
    refuse("group", "a correction of one host would move the surfaces of all",
           "leave out --watch or --group");
  if (options.depth.silhouettes && !options.record.empty())
    refuse("record", "a run with silhouettes cannot be shown again bit for bit", "leave one of them out");
}

/// The parts of one show, in the order in which they are made ready.
class ShowRun {
 public:
  ShowRun(const Rig& rig, bool is_calibrated, const ShowOptions& options, ShowListener& listener,
          device::FrameSink* sink = nullptr)
      : rig_(rig),
        is_calibrated_(is_calibrated),
        options_(options),
        listener_(listener),
        sink_(sink),
        in_room_(is_depth_source(options.surfaces)),
        folder_(content_folder(options.surfaces)),
        silhouettes_([this](const std::string& sentence) { listener_.on_event(sentence); }) {
    check_combination(options);
    ProjectionOptions projection = projection_options(options, rig);
    if (projection.renderer->device() != "cpu")
      listener_.on_start("drawn by " + projection.renderer->device());
    conditions_ = conditions_text(options, projection, rig);
    if (options.people)
      people_ =
          std::make_unique<ShowPeople>(*options.people, rig, rig.projector(options.projector),
                                       [this](const std::string& sentence) { listener_.on_event(sentence); });
    if (people_ || options.depth.silhouettes)
      projection.over = [this](const Projection& through, double light_time, ImageView<std::uint8_t> frame) {
        if (people_) people_->draw_over(through, light_time, frame);
        if (options_.depth.silhouettes) silhouettes_.add(room_->darken(frame, through, light_time));
      };
    if (in_room_) room_ = watch_room(options, rig, projection);
    if (!options.publish.empty()) {
      std::optional<Pose> world_from_rig;
      if (projection.projector_from_world)
        world_from_rig =
            (rig.projector(options.projector).rig_from_projector * *projection.projector_from_world)
                .inverse();
      graph_ = std::make_unique<Ros2Output>(options, rig, projection.child_from_rig, world_from_rig);
    }
    projection_ = std::make_unique<Projection>(rig, std::move(projection));
    load_surfaces();
    if (!options.group.empty()) open_group();
    open_output();
    open_inputs();
    if (link_) link_->wait_until_joined([this] { listener_.on_frame({}); });
  }

  ShowReport run() {
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
    parts.page = page_.get();
    parts.group = link_.get();
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
      sink_->finish();
      return report(metrics);
    } catch (...) {  // a listener that ends the show, or an output that broke: a video is kept all the same
      sink_->finish();
      throw;
    }
  }

 private:
  /// A message that fails does not end the show.
  void take_people() {
    if (!people_) return;
    try {
      people_->take(*projection_);
    } catch (const std::exception& error) {
      if (people_faults_++ == 0) listener_.on_event(error.what());
    }
  }

  void publish(const Metrics& metrics) {
    if (!graph_) return;
    try {
      graph_->publish(*projection_, metrics);
    } catch (const std::exception& error) {
      if (publish_faults_++ == 0) listener_.on_event(error.what());
    }
  }

  void publish_pose(const track::StampedPose& message) {
    if (!graph_) return;
    try {
      graph_->publish_pose(message, options_.source_delay_s);
    } catch (const std::exception& error) {
      if (publish_faults_++ == 0) listener_.on_event(error.what());
    }
  }

  /// By all sources of poses, images and depth.
  Rejected rejected() {
    Rejected sum;
    for (const auto& source : sources_) add_to(sum, source->rejected());
    if (room_) add_to(sum, room_->rejected());
    if (watch_) add_to(sum, watch_->rejected());
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

  void count_people_faults(std::map<std::string, std::uint64_t>& faults) const {
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

  ShowReport report(const Metrics& metrics) const {
    ShowReport report;
    report.metrics = metrics;
    report.poses = projection_->track().faults();
    if (people_) report.people = people_->counts();
    return report;
  }

  void load_surfaces() {
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

  void open_group() {
    dds::GroupOptions group;
    group.name = options_.group;
    group.strength = options_.group_strength;
    link_ = std::make_unique<GroupLink>(group, options_.surfaces);
    listener_.on_start(link_->description());
  }

  /// Of a source of this host, for the hosts that have none.
  void share_pose(const track::StampedPose& message) {
    if (!link_) return;
    try {
      link_->publish_pose(message);
    } catch (const std::exception& error) {
      if (group_faults_++ == 0) listener_.on_event(error.what());
    }
  }

  void open_output() {
    loop_.fps = options_.fps > 0 ? options_.fps : kUsualRate;
    loop_.duration_s = options_.duration_s;
    loop_.autosave = options_.autosave;
    if (sink_ != nullptr) {
      require(sink_->size() == projection_->frame_size(),
              "show::run: a sink of another size than the projector's");
    } else if (options_.output.empty()) {
      open_display();
    } else {
      device::SinkOptions sink;
      sink.size = projection_->frame_size();
      sink.fps = loop_.fps;
      opened_sink_ = device::open_sink(options_.output, sink);
      sink_ = opened_sink_.get();
    }
    loop_.delay_s = options_.delay_camera.empty() ? options_.delay_s : measured_delay();
  }

  void open_display() {
    const std::vector<device::Display> list = device::displays();
    const device::Display& display = device::choose_display(list, options_.display);
    const ImageSize size = projection_->frame_size();
    if (!(display.size == size))
      throw Error(ErrorKind::kDevice, "display " + std::to_string(display.number),
                  "it shows " + io::format_size(display.size) + " and the projector was calibrated with " +
                      io::format_size(size),
                  "set the display's mode to the projector's, or calibrate in this mode");
    opened_sink_ = device::open_window(display.number);
    sink_ = opened_sink_.get();
    if (options_.fps <= 0 && display.refresh_hz > 0) loop_.fps = display.refresh_hz;
    listener_.on_start("display " + std::to_string(display.number) + ": " + display.name + ", " +
                       io::format_size(display.size));
  }

  /// Domain and network of what listens in the ROS 2 graph.
  template <typename Source>
  void tell_opened(const Source& source) {
    if (const std::string opened = source.description(); !opened.empty()) listener_.on_start(opened);
  }

  /// From a frame's show() to its light on the wall, seen by a camera.
  double measured_delay() {
    const auto camera = device::open_camera(options_.delay_camera);
    const session::Delay delay =
        session::measure_delay({*sink_, *camera, [this] { listener_.on_frame({}); }});
    const double light = std::max(0.0, delay.delay_s - options_.camera_delay_s);
    char sentence[200];
    std::snprintf(sentence, sizeof sentence,
                  "delay from the window to the light: %.1f ms (the camera saw it after %.1f ms; %.1f ms of "
                  "them are taken for its own)",
                  1e3 * light, 1e3 * delay.delay_s, 1e3 * options_.camera_delay_s);
    listener_.on_start(sentence);
    return light;
  }

  void open_inputs() {
    for (const std::string& text : options_.poses) {
      sources_.push_back(dds::open_pose_source(text));
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

  const Rig& rig_;
  const bool is_calibrated_;
  const ShowOptions& options_;
  ShowListener& listener_;
  device::FrameSink* sink_;  ///< the caller's, or opened_sink_
  const bool in_room_;
  const fs::path folder_;
  std::string conditions_;
  BlackoutLog silhouettes_;
  std::unique_ptr<GroupLink> link_;  ///< outlives the sources
  std::uint64_t group_faults_ = 0;
  std::unique_ptr<ShowPeople> people_;
  std::uint64_t people_faults_ = 0;
  std::unique_ptr<Ros2Output> graph_;
  std::uint64_t publish_faults_ = 0;
  std::unique_ptr<DepthSurfaceSource> room_;
  std::unique_ptr<Projection> projection_;
  SurfaceSet first_;
  std::map<const device::ContentSource*, Rejected> by_content_;  ///< at the last count
  Rejected rejected_by_contents_;
  std::unique_ptr<ShowLoader> loader_;
  std::unique_ptr<device::FrameSink> opened_sink_;
  LoopOptions loop_;
  std::vector<std::unique_ptr<track::PoseSource>> sources_;
  std::optional<RunRecorder> recorder_;
  std::unique_ptr<LightWatch> watch_;
  std::unique_ptr<ControlPage> page_;
};

/// A recorded run that is read back, record by record.
struct Replay {
  Projection& projection;
  device::FrameSink& sink;
  const ShowOptions& options;
  const std::string& conditions;
  ShowListener& listener;
  ImageU8 frame;
  std::map<std::string, std::shared_ptr<device::ContentSource>> opened = {};
  ReplayReport report = {};
  std::string content_fault = {};  ///< that was reported last

  void operator()(const RunConditions& recorded) {
    if (recorded.text != conditions)
      listener.on_event("recorded under other conditions; frames may differ\n  then: " + recorded.text +
                        "\n  now:  " + conditions);
  }
  void operator()(const MissingParts& parts) {
    listener.on_event("parts " + std::to_string(parts.first) + " to " + std::to_string(parts.last) +
                      " of the log are missing: poses are filtered anew from here, and frames may differ");
  }
  void operator()(const SurfaceSet& set) {
    const fs::path beside = content_folder(options.surfaces) / "surfaces.json";
    device::ContentOptions exact;
    exact.pace = device::Pace::kExact;
    Show show;
    for (const Surface& surface : set.surfaces) {
      std::shared_ptr<device::ContentSource>& content = opened[surface.content];
      if (!content && !surface.content.empty())
        content = device::open_content(device::content_beside(beside, surface.content), exact);
      show.contents.push_back(content);
    }
    show.surfaces = set;
    projection.set_show(std::move(show));
  }
  void operator()(TestPattern picture) { projection.set_picture(picture); }
  void operator()(const MovedProjector& moved) { projection.move_projector(moved.rig_from_projector); }
  void operator()(const track::StampedPose& message) { projection.add(message); }
  void operator()(const RecordedFrame& recorded) {
    const DrawnFrame drawn = projection.draw(recorded.light_time, recorded.content_time, frame);
    if (!drawn.content_fault.empty() && drawn.content_fault != content_fault)
      listener.on_event(content_fault = drawn.content_fault);
    sink.show_next(frame);
    report.equal += fingerprint(frame) == recorded.fingerprint ? 1 : 0;
    ++report.frames;
    ShowReport so_far;
    so_far.metrics.frames = report.frames;
    listener.on_frame(so_far);
  }
};

ShowListener& listener_or_none(ShowListener* listener) {
  static ShowListener none;
  return listener != nullptr ? *listener : none;
}

}  // namespace

ShowReport run(const Rig& rig, const ShowOptions& options, ShowListener* listener) {
  return ShowRun(rig, true, options, listener_or_none(listener)).run();
}

ShowReport run(const Rig& rig, const ShowOptions& options, device::FrameSink& sink, ShowListener* listener) {
  return ShowRun(rig, true, options, listener_or_none(listener), &sink).run();
}

/// `sink`: nullptr for the options' own output.
static ShowReport run_without_rig(const ShowOptions& options, ImageSize size, device::FrameSink* sink,
                                  ShowListener& listener) {
  const Rig rig = stand_in_rig(size);
  if (!fs::exists(options.surfaces)) {
    const SurfaceSet first = first_surfaces(absolute_contents(options), size);
    ShowLoaderOptions writing;
    writing.surfaces = options.surfaces;
    ShowLoader(writing).save(first);
    listener.on_start(options.surfaces + " is new, with " + counted(first.surfaces.size(), "surface") +
                      "; drag the corners at the control page, and save");
  }
  return ShowRun(rig, false, options, listener, sink).run();
}

ShowReport run(const ShowOptions& options, ShowListener* listener) {
  check_combination(options);
  require_no_rig_needed(options);
  return run_without_rig(options, frame_size_without_rig(options), nullptr, listener_or_none(listener));
}

ShowReport run(const ShowOptions& options, device::FrameSink& sink, ShowListener* listener) {
  check_combination(options);
  require_no_rig_needed(options);
  return run_without_rig(options, sink.size(), &sink, listener_or_none(listener));
}

ReplayReport replay(const Rig& rig, const ShowOptions& options, const std::filesystem::path& log,
                    ShowListener* listener) {
  ProjectionOptions drawing = projection_options(options, rig);
  const std::string conditions = conditions_text(options, drawing, rig);
  Projection projection(rig, std::move(drawing));
  render::require_drawable(projection.frame_size());
  device::SinkOptions sink_options;
  sink_options.size = projection.frame_size();
  sink_options.fps = options.fps > 0 ? options.fps : kUsualRate;
  const auto sink = device::open_sink(options.output.empty() ? "none" : options.output, sink_options);
  Replay replay{projection,
                *sink,
                options,
                conditions,
                listener_or_none(listener),
                ImageU8(projection.frame_size(), 3)};
  RunReader reader(log, options.surfaces);
  while (const std::optional<RunRecord> record = reader.next()) std::visit(replay, *record);
  sink->finish();
  if (replay.report.frames == 0)
    throw Error(ErrorKind::kInput, log.string(), "it holds no frame, so nothing was compared",
                "give the log of a run that showed frames");
  return replay.report;
}

ImageU8 identification(ImageSize size, int number, const std::string& name) {
  ImageU8 picture(size, 3, 40);
  draw_words(picture, {std::to_string(number), name});
  return picture;
}

void identify_displays(ShowListener* listener) {
  constexpr double kTime = 3;  // seconds each
  for (const device::Display& display : device::displays()) {
    listener_or_none(listener).on_start("display " + std::to_string(display.number) + ": " + display.name);
    const auto window = device::open_window(display.number);
    window->show(identification(window->size(), display.number, display.name));
    for (const double end = device::now_s() + kTime;
         device::now_s() < end && window->poll() != device::WindowEvent::kClose;) {
      listener_or_none(listener).on_frame({});
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
}

}  // namespace procam::show
