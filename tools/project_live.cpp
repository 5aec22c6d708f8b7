/// project-live: rig + surfaces + contents + poses -> frames on a projector, until it is stopped.
#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <map>
#include <thread>

#include "common/cli.hpp"
#include "common/dark_words.hpp"
#include "common/depth_room.hpp"
#include "common/people_flags.hpp"
#include "common/room_frames.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/device/content_source.hpp"
#include "procam/device/frame_source.hpp"
#include "procam/io/files.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/io/text.hpp"
#include "procam/render/gl.hpp"
#include "procam/session/capture.hpp"
#include "procam/show/loop.hpp"
#include "procam/show/marker_source.hpp"
#include "procam/show/overlay.hpp"

namespace procam::tools {
namespace {

namespace fs = std::filesystem;

struct Flags {
  std::string rig, projector, surfaces, pose, mount;
  std::vector<std::string> contents, sources;
  std::string predict = "auto", frame, child;
  std::optional<std::string> display;
  std::string output;
  std::string marker_camera, markers, marker_camera_name;
  std::optional<MarkerMap> marker;
  DepthRoomFlags room;
  bool list_displays = false, identify = false;
  std::string delay = "0ms", camera;
  double camera_delay = 0;
  double fps = 0, duration = 0;
  double source_delay = 0;
  std::optional<double> blank_on_stale, freeze_on_stale;
  std::string record, replay;
  std::string control = "127.0.0.1:8737", token;
  std::string renderer = "cpu";
  int threads = 0;
  bool bilinear = false, encoded = false;
  PeopleFlags people;
};

void declare(CLI::App& app, Flags& flags) {
  const auto duration = [&](const char* name, double& into, const char* help) {
    return add_parsed(
        app, name, [&into](const std::string& text) { into = io::parse_duration(text); }, help);
  };
  app.add_option("--rig", flags.rig, "rig.json, as calibrate-projector writes it");
  app.add_option("--projector", flags.projector, "its name, for a rig with several");
  app.add_option(
      "--surfaces", flags.surfaces,
      "surface definitions, .json or .xml: read again whenever the file changes; or "
      "depth:watch:FOLDER, depth:folder:FOLDER, depth:openni2:[URI]: as the rig's depth camera sees them");
  declare_depth_room(app, flags.room);
  app.add_option("--content", flags.contents,
                 "SURFACE=WHAT: a picture, a folder or pattern of pictures, a video, camera:0, shm:NAME, "
                 "#rrggbb; else the surface file's own");
  app.add_option("--pose-source", flags.sources,
                 "where poses come from: udp:9000, tcp:HOST:PORT, tcp-listen:PORT, osc:PORT, psn:PORT, "
                 "rosbridge:HOST:PORT, log:FILE");
  app.add_option("--marker-camera", flags.marker_camera,
                 "poses from what the rig's camera sees of a marker: its number, device or URL")
      ->excludes(app.get_option("--pose-source"));
  add_parsed(
      app, "--marker", [&](const std::string& text) { flags.marker = io::parse_marker(text); },
      "the marker, whose frame becomes the world: DICTIONARY:ID:SIZE, e.g. apriltag_36h11:3:160mm");
  app.add_option("--markers", flags.markers, "markers.json: several markers and their places in the world");
  app.add_option("--marker-camera-name", flags.marker_camera_name,
                 "its name in the rig, for a rig with several cameras");
  app.add_option("--pose", flags.pose, "a pose.json instead, for a projector that stands still");
  app.add_option(
      "--mount", flags.mount,
      "pose.json that places the rig, its projector or a camera on what the poses tell of ('base'); "
      "default: they tell of the rig");
  app.add_option("--frame", flags.frame,
                 "the poses' parent frame, which is the surfaces' world (default: the first seen)");
  app.add_option("--child", flags.child, "the poses' moving frame (default: the first seen)");
  app.add_option("--predict", flags.predict, "to the moment of light: auto, twist, acceleration or none")
      ->capture_default_str();
  duration("--source-delay", flags.source_delay,
           "from the moment that a pose speaks of to its arrival at the fastest, e.g. 40ms");
  app.add_option("--display", flags.display,
                 "full screen on it: number, name or a place on the desktop ('1920,0')");
  app.add_option("--output", flags.output,
                 "instead of a display: frames:FOLDER, video:FILE, stdout, shm:NAME or none");
  app.add_flag("--list-displays", flags.list_displays, "say which displays there are, and end");
  app.add_flag("--identify", flags.identify, "show each display its number for three seconds, and end");
  app.add_option("--delay", flags.delay,
                 "from a frame's begin to its light, e.g. 35ms; auto: measured with --camera before the show")
      ->capture_default_str();
  app.add_option("--camera", flags.camera, "camera that looks at the light, for --delay auto");
  duration("--camera-delay", flags.camera_delay, "the camera's own share of what it measures");
  app.add_option("--fps", flags.fps, "frames a second (default: the display's, or 60)")
      ->check(CLI::Range(0.1, 1000.0));
  duration("--duration", flags.duration, "end after it, e.g. 30s");
  add_parsed(
      app, "--blank-on-stale",
      [&](const std::string& text) { flags.blank_on_stale = io::parse_duration(text); },
      "black when no pose has come for so long, e.g. 500ms");
  add_parsed(
      app, "--freeze-on-stale",
      [&](const std::string& text) { flags.freeze_on_stale = io::parse_duration(text); },
      "drawn from where the robot was when no pose has come for so long (default: 500ms)");
  declare(app, flags.people);
  app.add_option("--record", flags.record, "write the run to this log, for --replay");
  app.add_option("--replay", flags.replay, "show a recorded run again, frame by frame, and compare");
  app.add_option("--control", flags.control, "[ADDRESS:]PORT of the control page, or off")
      ->capture_default_str();
  app.add_option("--token", flags.token, "the control page's secret (default: a new one)");
  app.add_option("--threads", flags.threads, "0: as many as the machine has")->check(CLI::NonNegativeNumber);
  app.add_option("--renderer", flags.renderer, "cpu, or gl for OpenGL: the same picture")
      ->check(CLI::IsMember({"cpu", "gl"}))
      ->capture_default_str();
  app.add_flag("--bilinear", flags.bilinear,
               "one sample a pixel: faster, and aliases where content is minified");
  app.add_flag("--average-numbers", flags.encoded, "average pixel values as they stand instead of the light");
}

std::string size_text(ImageSize size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

void list_displays(Console& console) {
  std::vector<std::string> lines;
  for (const device::Display& display : device::displays()) {
    lines.push_back(format("%d: %s, %s at %d,%d, %.0f Hz%s", display.number, display.name.c_str(),
                           size_text(display.size).c_str(), display.x, display.y, display.refresh_hz,
                           display.is_primary ? ", primary" : ""));
    console.say("display " + lines.back());
  }
  console.summary().set("/displays", lines);
}

void identify(Console& console) {
  for (const device::Display& display : device::displays()) {
    console.say(format("display %d: %s", display.number, display.name.c_str()));
    const auto window = device::open_window(display.number);
    ImageU8 picture(window->size(), 3, 40);
    show::draw_words(picture, {std::to_string(display.number), display.name});
    window->show(picture);
    for (const double end = device::now_s() + 3;
         device::now_s() < end && window->poll() != device::WindowEvent::kClose;) {
      console.progress("display", display.number, 0);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
}

/// --content: what each named surface shows.
std::map<std::string, std::string> given_contents(const std::vector<std::string>& given) {
  std::map<std::string, std::string> contents;
  for (const std::string& item : given) {
    const std::size_t equals = item.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == item.size())
      throw Error(ErrorKind::kInput, "--content " + item, "it does not read SURFACE=WHAT",
                  "write e.g. --content wall=wall.png");
    // As typed, it is beside where the tool runs.
    contents[item.substr(0, equals)] =
        device::content_beside(fs::current_path() / "surfaces.json", item.substr(equals + 1));
  }
  return contents;
}

/// Beside which contents are found.
fs::path folder_of(const std::string& surfaces) {
  return is_depth_room(surfaces) ? fs::current_path() : fs::absolute(surfaces).parent_path();
}

std::vector<std::string> choices(const fs::path& folder, const SurfaceSet& set) {
  std::vector<std::string> found = device::content_files(folder, 200);
  for (const Surface& surface : set.surfaces)
    if (!surface.content.empty() && std::find(found.begin(), found.end(), surface.content) == found.end())
      found.push_back(surface.content);
  for (const char* colour : {"#ffffff", "#ff0000", "#00ff00", "#0000ff"}) found.emplace_back(colour);
  return found;
}

struct Drawing {
  show::DrawScene draw;
  std::string by;  ///< cpu, or the driver's words for who draws
};

Drawing drawing_by(const Flags& flags) {
  render::RenderOptions options;
  options.threads = flags.threads;
  options.filter = flags.bilinear ? render::Filter::kBilinear : render::Filter::kArea;
  options.linear_light = !flags.encoded;
  const auto with = [](auto renderer) {
    return [renderer](const Scene& scene, const Projector& through, ImageView<std::uint8_t> frame) {
      return renderer->render(scene, through, frame);
    };
  };
  if (flags.renderer == "cpu") return {with(std::make_shared<render::CpuRenderer>(options)), "cpu"};
  auto renderer = std::make_shared<render_gl::GlRenderer>(options);
  return {with(renderer), renderer->device()};
}

show::ProjectionOptions projection_options(const Flags& flags, const Rig& rig, const Drawing& drawing) {
  const RigProjector& projector = rig.projector(flags.projector);
  show::ProjectionOptions options;
  options.projector = projector.name;
  if (!flags.pose.empty())
    options.projector_from_world =
        room_frames(rig, projector, io::load_pose(flags.pose)).get(projector.name, "world").pose;
  if (!flags.mount.empty()) {
    FrameTree::Link mount = io::load_pose(flags.mount);
    if (mount.target != "base" && mount.source != "base")
      throw Error(ErrorKind::kInput, flags.mount, "it does not tell where anything is on 'base'",
                  "give a pose between 'base' and the rig, its projector or a camera");
    // room_frames() hangs a device's surroundings on the rig under the name "world".
    (mount.target == "base" ? mount.target : mount.source) = "world";
    options.child_from_rig = room_frames(rig, projector, std::move(mount)).get("world", "rig").pose;
  }
  options.track.frame = flags.frame;
  options.track.child = flags.child;
  options.track.prediction = track::parse_prediction(flags.predict);
  options.track.delay = flags.source_delay;
  if (flags.blank_on_stale) options.track.stale_after = *flags.blank_on_stale;
  if (flags.freeze_on_stale) options.track.stale_after = *flags.freeze_on_stale;
  options.blank_on_stale = flags.blank_on_stale.has_value();
  options.draw = drawing.draw;
  return options;
}

/// What frames depend on besides what a log holds.
std::string conditions(const Flags& flags, const show::ProjectionOptions& options, const Drawing& drawing) {
  return format("projector %s, predict %s, source delay %g s, stale %g s%s, %s%s by %s, rig %.16s",
                options.projector.c_str(), flags.predict.c_str(), flags.source_delay,
                options.track.stale_after, options.blank_on_stale ? " to black" : "",
                flags.bilinear ? "bilinear" : "area", flags.encoded ? " of numbers" : "", drawing.by.c_str(),
                io::sha256_of_file(flags.rig).c_str()) +
         (flags.pose.empty() ? "" : ", pose " + io::sha256_of_file(flags.pose).substr(0, 16)) +
         (flags.mount.empty() ? "" : ", mount " + io::sha256_of_file(flags.mount).substr(0, 16));
}

/// A run that is read back, line by line.
struct Replay {
  show::Projection& projection;
  device::FrameSink& sink;
  const fs::path folder;    ///< of contents
  const std::string given;  ///< conditions
  Console& console;
  ImageU8 frame;
  std::map<std::string, std::shared_ptr<device::ContentSource>> opened = {};
  long long frames = 0, equal = 0;

  void operator()(const show::RunConditions& recorded) {
    if (recorded.text != given)
      console.log("recorded under other conditions; frames may differ\n  then: " + recorded.text +
                  "\n  now:  " + given);
  }
  void operator()(const SurfaceSet& set) {
    show::Show show;
    device::ContentOptions options;
    options.pace = device::Pace::kExact;
    for (const Surface& surface : set.surfaces) {
      std::shared_ptr<device::ContentSource>& content = opened[surface.content];
      if (!content && !surface.content.empty())
        content =
            device::open_content(device::content_beside(folder / "surfaces.json", surface.content), options);
      show.contents.push_back(content);
    }
    show.surfaces = set;
    projection.set_show(std::move(show));
  }
  void operator()(show::TestPattern picture) { projection.set_picture(picture); }
  void operator()(const track::StampedPose& message) { projection.add(message); }
  void operator()(const show::RecordedFrame& recorded) {
    projection.draw(recorded.light_time, recorded.content_time, frame);
    sink.show_next(frame);
    equal += show::fingerprint(frame) == recorded.fingerprint ? 1 : 0;
    console.progress("frame", int(++frames), 0);
  }
};

ExitCode replay(const Flags& flags, Console& console) {
  const Rig rig = io::load_rig(flags.rig);
  const Drawing drawing = drawing_by(flags);
  show::ProjectionOptions options = projection_options(flags, rig, drawing);
  const std::string given = conditions(flags, options, drawing);
  show::Projection projection(rig, std::move(options));
  device::SinkOptions sink_options;
  sink_options.size = projection.frame_size();
  sink_options.fps = flags.fps > 0 ? flags.fps : 60;
  const auto sink = device::open_sink(flags.output.empty() ? "none" : flags.output, sink_options);
  render::require_drawable(projection.frame_size());
  Replay replay{projection, *sink,   folder_of(flags.surfaces),
                given,      console, ImageU8(projection.frame_size(), 3)};
  show::RunReader reader(flags.replay, flags.surfaces);
  while (const std::optional<show::RunRecord> record = reader.next()) std::visit(replay, *record);
  sink->finish();
  console.say(format("%lld frames, %lld of them equal to the recorded ones bit for bit", replay.frames,
                     replay.equal));
  console.summary().set("/frames", double(replay.frames));
  console.summary().set("/equal", double(replay.equal));
  return replay.frames == replay.equal ? ExitCode::kOk : ExitCode::kGateFailed;
}

/// From a frame's show() to its light on the wall, seen by a camera.
double measure(device::FrameSink& sink, const Flags& flags, Console& console) {
  if (flags.camera.empty())
    throw Error(ErrorKind::kInput, "--delay auto", "no camera looks at the light",
                "give --camera, or the delay");
  const auto camera = device::open_camera(flags.camera);
  const session::Delay delay =
      session::measure_delay({sink, *camera, [&] { console.progress("measuring the delay", 0, 0); }});
  const double light = std::max(0.0, delay.delay_s - flags.camera_delay);
  console.say(format(
      "delay from the window to the light: %.1f ms (the camera saw it after %.1f ms; %.1f ms of them are "
      "taken for its own)",
      1e3 * light, 1e3 * delay.delay_s, 1e3 * flags.camera_delay));
  return light;
}

void set(Summary& summary, const std::string& at, const show::Durations& durations) {
  summary.set(at + "/p50", 1e3 * durations.quantile(0.5));
  summary.set(at + "/p90", 1e3 * durations.quantile(0.9));
  summary.set(at + "/p99", 1e3 * durations.quantile(0.99));
  summary.set(at + "/largest", 1e3 * durations.largest());
}

void tell(const show::Metrics& m, const show::Projection& projection, Console& console) {
  console.say(format("%llu frames, %llu skipped as too late, %llu black without a pose",
                     (unsigned long long)m.frames, (unsigned long long)m.dropped,
                     (unsigned long long)m.blanked));
  const std::pair<const char*, const show::Durations*> rows[] = {{"draw", &m.draw},
                                                                 {"render", &m.render},
                                                                 {"jitter", &m.jitter},
                                                                 {"pose_age", &m.pose_age},
                                                                 {"pose_to_frame", &m.pose_to_frame}};
  console.say(format("%-14s %9s %9s %9s %9s", "ms", "p50", "p90", "p99", "largest"));
  for (const auto& [name, durations] : rows) {
    console.say(format("%-14s %9.2f %9.2f %9.2f %9.2f", name, 1e3 * durations->quantile(0.5),
                       1e3 * durations->quantile(0.9), 1e3 * durations->quantile(0.99),
                       1e3 * durations->largest()));
    set(console.summary(), std::string("/") + name + "_ms", *durations);
  }
  Summary& summary = console.summary();
  summary.set("/frames", double(m.frames));
  summary.set("/dropped", double(m.dropped));
  summary.set("/blanked", double(m.blanked));
  summary.set("/reloads", double(m.reloads));
  summary.set("/failed_reloads", double(m.failed_reloads));
  summary.set("/poses/arrived", double(m.poses));
  summary.set("/poses/malformed", double(m.malformed));
  const track::Faults& f = projection.track().faults();
  const std::pair<const char*, std::uint64_t> faults[] = {
      {"taken", f.taken},           {"reordered", f.reordered}, {"late", f.late},
      {"duplicated", f.duplicated}, {"outliers", f.outliers},   {"doubtful", f.doubtful},
      {"invalid", f.invalid},       {"foreign", f.foreign},     {"lost", f.lost},
      {"stale", f.stale},           {"map_jumps", f.map_jumps}, {"clock_jumps", f.clock_jumps}};
  std::string words;
  for (const auto& [name, count] : faults) {
    summary.set(std::string("/poses/") + name, double(count));
    if (count > 0) words += format("%s%s %llu", words.empty() ? "" : ", ", name, (unsigned long long)count);
  }
  if (!words.empty())
    console.say("poses: " + words + format(", malformed %llu", (unsigned long long)m.malformed));
}

std::pair<std::string, int> split_address(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  const std::string port = colon == std::string::npos ? text : text.substr(colon + 1);
  std::string address = colon == std::string::npos ? "127.0.0.1" : text.substr(0, colon);
  if (address.size() > 2 && address.front() == '[') address = address.substr(1, address.size() - 2);
  if (port.empty() || port.size() > 5 || port.find_first_not_of("0123456789") != std::string::npos)
    throw Error(ErrorKind::kInput, "--control " + text, "it does not end in a port",
                "give e.g. 8737, 0.0.0.0:8737 or off");
  return {address, std::stoi(port)};
}

std::unique_ptr<track::PoseSource> see_markers(const Flags& flags, const Rig& rig) {
  if (!flags.marker && flags.markers.empty())
    throw Error(ErrorKind::kInput, "--marker-camera", "no marker is named", "give --marker or --markers");
  const MarkerMap map = flags.marker ? *flags.marker : io::load_marker_map(flags.markers);
  const RigCamera& camera = rig.camera(flags.marker_camera_name);
  device::CameraOptions options;
  options.size = camera.camera.size;
  return std::make_unique<show::MarkerSource>(device::open_camera(flags.marker_camera, options), camera, map,
                                              detect::marker_cells(map.dictionary));
}

ExitCode show(const Flags& flags, Console& console) {
  const Rig rig = io::load_rig(flags.rig);
  const Drawing drawing = drawing_by(flags);
  if (drawing.by != "cpu") console.say("drawn by " + drawing.by);
  show::ProjectionOptions options = projection_options(flags, rig, drawing);
  const std::string recorded_conditions = conditions(flags, options, drawing);
  std::unique_ptr<ShowPeople> people;
  if (!flags.people.source.empty()) {
    if (!flags.record.empty())
      throw Error(ErrorKind::kInput, "--record", "a run with --people cannot be shown again bit for bit",
                  "leave one of them out");
    people = std::make_unique<ShowPeople>(flags.people, rig, rig.projector(flags.projector),
                                          [&](const std::string& sentence) { console.log(sentence); });
  }
  const bool in_room = is_depth_room(flags.surfaces);
  if (flags.room.silhouettes && !in_room)
    throw Error(ErrorKind::kInput, "--silhouettes", "no depth camera sees the room",
                "give --surfaces depth:SOURCE");
  if (flags.room.silhouettes && !flags.record.empty())
    throw Error(ErrorKind::kInput, "--record", "a run with --silhouettes cannot be shown again bit for bit",
                "leave one of them out");
  std::unique_ptr<show::DepthSurfaceSource> room;
  DarkWords silhouettes([&](const std::string& sentence) { console.log(sentence); });
  if (people || flags.room.silhouettes)
    options.over = [&](const show::Projection& through, double light_time, ImageView<std::uint8_t> frame) {
      if (people) people->over(through, light_time, frame);
      if (flags.room.silhouettes) silhouettes.tell(room->darken(frame, through, light_time));
    };
  if (in_room) {
    // Without poses the rig stands still and is the world.
    const bool rig_is_world = flags.sources.empty() && flags.marker_camera.empty() && flags.pose.empty();
    if (rig_is_world)
      options.projector_from_world = rig.projector(flags.projector).rig_from_projector.inverse();
    room = watch_room(flags.surfaces, flags.room, rig, options, rig_is_world);
  }
  show::Projection projection(rig, std::move(options));
  const fs::path folder = folder_of(flags.surfaces);

  show::ShowLoaderOptions loading;
  const std::map<std::string, std::string> contents = given_contents(flags.contents);
  if (!in_room) {
    loading.surfaces = flags.surfaces;
    loading.contents = contents;
  }
  loading.folder = folder;
  // A frame of a run that is to be shown again waits for its picture.
  loading.pace = flags.record.empty() ? device::Pace::kLive : device::Pace::kExact;
  const SurfaceSet first = show::load_surfaces(loading);  // throws what is wrong with it
  show::ShowLoader loader(loading);
  show::LoadedShow loaded = loader.load_now();
  for (const std::string& fault : loaded.faults) console.log(fault);
  if (!loaded.show)
    throw Error(ErrorKind::kInput, flags.surfaces, "it changed while it was read", "start again");
  projection.set_show(std::move(*loaded.show));

  device::SinkOptions sink_options;
  sink_options.size = projection.frame_size();
  sink_options.fps = flags.fps > 0 ? flags.fps : 60;
  show::LoopOptions loop;
  loop.fps = sink_options.fps;
  loop.duration_s = flags.duration;
  std::unique_ptr<device::FrameSink> sink;
  if (flags.output.empty()) {
    const std::vector<device::Display> list = device::displays();
    const device::Display& display = device::choose_display(list, flags.display);
    if (!(display.size == projection.frame_size()))
      throw Error(ErrorKind::kDevice, "display " + std::to_string(display.number),
                  "it shows " + size_text(display.size) + " and the projector was calibrated with " +
                      size_text(projection.frame_size()),
                  "set the display's mode to the projector's, or calibrate in this mode");
    sink = device::open_window(display.number);
    if (flags.fps <= 0 && display.refresh_hz > 0) loop.fps = display.refresh_hz;
    console.say(
        format("display %d: %s, %s", display.number, display.name.c_str(), size_text(display.size).c_str()));
  } else {
    sink = device::open_sink(flags.output, sink_options);
  }
  loop.delay_s = flags.delay == "auto" ? measure(*sink, flags, console) : io::parse_duration(flags.delay);

  std::vector<std::unique_ptr<track::PoseSource>> sources;
  show::Editor editor(first);
  show::LoopParts parts{projection, *sink};
  for (const std::string& text : flags.sources) sources.push_back(track::open_pose_source(text));
  if (!flags.marker_camera.empty()) sources.push_back(see_markers(flags, rig));
  for (const auto& source : sources) parts.sources.push_back(source.get());
  if (!in_room) parts.editor = &editor;
  parts.loader = &loader;
  parts.room = room.get();
  if (in_room) parts.room_contents = contents;
  std::optional<show::RunRecorder> recorder;
  if (!flags.record.empty()) parts.recorder = &recorder.emplace(flags.record, recorded_conditions);
  std::unique_ptr<show::ControlPage> page;
  if (flags.control != "off") {
    show::ControlOptions control;
    std::tie(control.address, control.port) = split_address(flags.control);
    control.token = flags.token;
    page = std::make_unique<show::ControlPage>(control);
    parts.page = page.get();
    console.say("control page: " + page->url());
  }
  parts.contents = choices(folder, first);
  parts.say = [&](const std::string& sentence) { console.log(sentence); };
  // A recorded run begins from what its log holds, digit by digit.
  if (parts.recorder != nullptr) {
    show::Show again = projection.show();
    again.surfaces = io::surfaces_from_text(io::surfaces_to_text(again.surfaces), flags.surfaces);
    projection.set_show(std::move(again));
  }
  show::Metrics so_far;
  parts.tick = [&](const show::Metrics& metrics) {
    so_far = metrics;
    if (people) people->take(projection);
    if (metrics.frames % 16 == 0) console.progress("frame", int(metrics.frames), 0);
  };
  try {
    so_far = show::run_loop(parts, loop);
  } catch (...) {  // Ctrl-C, a pipe that broke: what was measured is told, and a video is kept, all the same
    tell(so_far, projection, console);
    if (people) people->tell(console);
    sink->finish();
    throw;
  }
  tell(so_far, projection, console);
  if (people) people->tell(console);
  sink->finish();
  return ExitCode::kOk;
}

ExitCode run(const Flags& flags, Console& console) {
  if (flags.list_displays) return list_displays(console), ExitCode::kOk;
  if (flags.identify) return identify(console), ExitCode::kOk;
  const auto need = [](const std::string& value, const char* flag) {
    if (value.empty())
      throw Error(ErrorKind::kInput, flag, "it is not given", "see project-live --help for a line to try");
  };
  need(flags.rig, "--rig");
  need(flags.surfaces, "--surfaces");
  return flags.replay.empty() ? show(flags, console) : replay(flags, console);
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  Flags flags;
  return run_tool(
      argc, argv,
      {"project-live",
       "projects onto surfaces while the robot moves: poses come in over the network, are predicted to the "
       "moment of light, and every frame is drawn for it. A control page shows the frame and moves corners.",
       "project-live --rig rig.json --surfaces surfaces.json --content wall=picture.png --pose-source "
       "udp:9000 --blank-on-stale 500ms"},
      [&](CLI::App& app) { declare(app, flags); }, [&](Console& console) { return run(flags, console); });
}
