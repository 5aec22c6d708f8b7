#include "common/show_flags.hpp"

#include <CLI/CLI.hpp>

#include "common/cli.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/io/text.hpp"

namespace procam::tools {
namespace {

double parse_depth_scale(const std::string& text) {
  const double scale = io::parse_length(text);
  if (!(scale > 0 && scale < 1))
    throw Error(ErrorKind::kInput, "'" + text + "'", "one step of a depth picture cannot be that long",
                "give the unit of its numbers, e.g. 1mm, or 0.2mm for 1/5000 m");
  return scale;
}

template <typename Target>
auto into(Target& target, double (*parse)(const std::string&)) {
  return [&target, parse](const std::string& text) { target = parse(text); };
}

show::MarkerInput& marker_of(show::ShowOptions& options) {
  return options.marker ? *options.marker : options.marker.emplace();
}
show::PeopleInput& people_of(show::ShowOptions& options) {
  return options.people ? *options.people : options.people.emplace();
}

void declare_surfaces(CLI::App& app, show::ShowOptions& o) {
  app.add_option(
      "--surfaces", o.surfaces,
      "surface definitions, .json or .xml: read again whenever the file changes; or depth:watch:FOLDER, "
      "depth:folder:FOLDER, depth:openni2:[URI]: as the rig's depth camera sees them");
  app.add_option("--depth-camera", o.depth.camera, "with --surfaces depth: its name in the rig, for several");
  add_parsed(app, "--depth-scale", into(o.depth.metres_per_unit, parse_depth_scale),
             "unit of a depth picture's 16-bit numbers, where no sensor states it (default: 1mm)");
  add_parsed(app, "--depth-delay", into(o.depth.delay_s, io::parse_delay),
             "from a depth picture's exposure to its arrival, e.g. 30ms");
  add_parsed(
      app, "--up", [&](const std::string& text) { o.depth.up = io::parse_direction(text); },
      "which way is up in the world, x,y,z (default: 0,0,1; without poses 0,-1,0, the rig's)");
  app.add_flag("--silhouettes", o.depth.silhouettes,
               "with --surfaces depth: objects in front of the room are masked, people as a "
               "whole; dark while depth is silent");
  app.add_option_function<std::vector<std::string>>(
      "--content",
      [&](const std::vector<std::string>& items) {
        for (const std::string& item : items) {
          const std::size_t equals = item.find('=');
          if (equals == std::string::npos || equals == 0 || equals + 1 == item.size())
            throw Error(ErrorKind::kInput, "--content " + item, "it does not read SURFACE=WHAT",
                        "write e.g. --content wall=wall.png");
          o.contents[item.substr(0, equals)] = item.substr(equals + 1);
        }
      },
      "SURFACE=WHAT: a picture, a folder or pattern of pictures, a video, camera:0, shm:NAME, #rrggbb; else "
      "the surface file's own");
}

void declare_poses(CLI::App& app, show::ShowOptions& o) {
  CLI::Option* sources =
      app.add_option("--pose-source", o.poses,
                     "where poses come from: udp:9000, tcp:HOST:PORT, tcp-listen:PORT, osc:PORT, psn:PORT, "
                     "rosbridge:HOST:PORT, log:FILE");
  const auto marker = [&](const char* flag, std::string show::MarkerInput::*member, const char* help) {
    return app.add_option_function<std::string>(
        flag, [&o, member](const std::string& text) { marker_of(o).*member = text; }, help);
  };
  CLI::Option* camera = marker("--marker-camera", &show::MarkerInput::camera,
                               "poses from what the rig's camera sees of a marker: its number, device or URL")
                            ->excludes(sources);
  marker("--marker", &show::MarkerInput::marker,
         "the marker, whose frame becomes the world: DICTIONARY:ID:SIZE, e.g. apriltag_36h11:3:160mm")
      ->needs(camera);
  marker("--markers", &show::MarkerInput::markers,
         "markers.json: several markers and their places in the world")
      ->needs(camera);
  marker("--marker-camera-name", &show::MarkerInput::name,
         "its name in the rig, for a rig with several cameras")
      ->needs(camera);
  app.add_option("--pose", o.pose, "a pose.json instead, for a projector that stands still");
  app.add_option(
      "--mount", o.mount,
      "pose.json that places the rig, its projector or a camera on what the poses tell of ('base'); "
      "default: they tell of the rig");
  app.add_option("--frame", o.frame,
                 "the poses' parent frame, which is the surfaces' world (default: the first seen)");
  app.add_option("--child", o.child, "the poses' moving frame (default: the first seen)");
  app.add_option("--predict", o.prediction, "to the moment of light: auto, twist, acceleration or none")
      ->capture_default_str();
  add_parsed(app, "--source-delay", into(o.source_delay_s, io::parse_delay),
             "from the moment that a pose speaks of to its arrival at the fastest, e.g. 40ms");
  add_parsed(app, "--blank-on-stale", into(o.blank_on_stale_s, io::parse_duration),
             "black when no pose has come for so long, e.g. 500ms");
  add_parsed(app, "--freeze-on-stale", into(o.freeze_on_stale_s, io::parse_duration),
             "drawn from where the robot was when no pose has come for so long (default: 500ms)");
}

void declare_people(CLI::App& app, show::ShowOptions& o) {
  CLI::Option* people = app.add_option_function<std::string>(
      "--people", [&](const std::string& text) { people_of(o).source = text; },
      "skeletons of the people before the projector, whose heads are kept dark: udp:9100, tcp:HOST:PORT, "
      "tcp-listen:PORT, vmc:39539, log:FILE");
  app.add_option_function<std::string>(
         "--sensor", [&](const std::string& text) { people_of(o).sensor = text; },
         "pose.json between 'sensor', which sees the people, and the rig, its projector, a camera or the world")
      ->needs(people);
  add_parsed(
      app, "--sensor-delay", [&](const std::string& text) { people_of(o).delay_s = io::parse_delay(text); },
      "from the moment that a skeleton speaks of to its arrival at the fastest, e.g. 50ms")
      ->needs(people);
  app.add_option_function<std::vector<std::string>>(
         "--people-to", [&](const std::vector<std::string>& list) { people_of(o).destinations = list; },
         "SURFACE=udp:HOST:PORT: the skeletons in metres of that surface, for what draws its content")
      ->needs(people);
}

void declare_output(CLI::App& app, show::ShowOptions& o) {
  app.add_option("--display", o.display,
                 "full screen on it: number, name or a place on the desktop ('1920,0')");
  app.add_option("--output", o.output,
                 "instead of a display: frames:FOLDER, video:FILE, stdout, shm:NAME or none");
  app.add_option("--camera", o.delay_camera,
                 "camera that looks at the light: it measures the delay before the show");
  add_parsed(
      app, "--size", [&](const std::string& text) { o.size = io::parse_size(text); },
      "the frame, e.g. 1280x800, where neither --rig nor a display states it");
  app.add_option_function<std::string>(
      "--delay",
      [&](const std::string& text) {
        if (text != "auto") {
          o.delay_s = io::parse_delay(text);
          o.delay_camera.clear();
        } else if (o.delay_camera.empty()) {
          throw Error(ErrorKind::kInput, "--delay auto", "no camera looks at the light",
                      "give --camera, or the delay");
        }
      },
      "from a frame's begin to its light, e.g. 35ms; auto: measured with --camera (default: 0ms)");
  add_parsed(app, "--camera-delay", into(o.camera_delay_s, io::parse_delay),
             "the camera's own share of what it measures");
  app.add_option("--fps", o.fps, "frames a second (default: the display's, or 60)")->check(within(0.1, 1000));
  add_parsed(app, "--duration", into(o.duration_s, io::parse_duration), "end after it, e.g. 30s");
  app.add_flag("--autosave", o.autosave,
               "save edits of the control page to the surfaces file within a second");
  app.add_option("--record", o.record, "write the run to this log, for --replay");
  app.add_option("--control", o.control, "[ADDRESS:]PORT of the control page, or off")->capture_default_str();
  app.add_option("--token", o.token, "the control page's secret (default: a new one)");
  app.add_option("--threads", o.threads, "0: as many as the machine has")
      ->check(CLI::Range(0, limits::kThreads));
  app.add_option("--renderer", o.renderer, "cpu, or gl for OpenGL: the same picture")
      ->check(CLI::IsMember({"cpu", "gl"}))
      ->capture_default_str();
  app.add_flag("--bilinear", o.bilinear, "one sample a pixel: faster, and aliases where content is minified");
  app.add_flag("--average-numbers", o.average_numbers,
               "average pixel values as they stand instead of the light");
}

}  // namespace

void declare_show(CLI::App& app, show::ShowOptions& options) {
  // The first one: options take effect in the order in which they are declared.
  app.add_option_function<std::string>(
      "--show", [&](const std::string& file) { options = show::load_options(file); },
      "show.json with all that follows (docs/live.md); other flags change what it says");
  app.add_option("--projector", options.projector, "its name, for a rig with several");
  declare_surfaces(app, options);
  declare_poses(app, options);
  declare_people(app, options);
  declare_output(app, options);
}

}  // namespace procam::tools
