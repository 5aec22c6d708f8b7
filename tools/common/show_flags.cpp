#include "common/show_flags.hpp"

#include <CLI/CLI.hpp>

#include "common/blend_flags.hpp"
#include "common/cli.hpp"
#include "common/help.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/io/text.hpp"

namespace procam::tools {
namespace {

double parse_depth_scale(const std::string& text) {
  const double scale = io::parse_length(text);
  if (!(scale > 0 && scale < 1))
    throw Error(ErrorKind::kInput, "'" + text + "'", "one step of a depth image cannot be that long",
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
      "Surface definitions, .json or .xml, read again when the file changes; or surfaces found by "
      "the depth camera of the rig: depth:watch:FOLDER, depth:folder:FOLDER, depth:openni2:[URI], "
      "depth:ros2:/TOPIC, depth:log:FILE+/TOPIC; or one surface that moves and deforms, \"shape\": "
      "depth-shape:SOURCE[,region=X:Y:WIDTHxHEIGHT], the region in pixels of the depth camera");
  app.add_option("--depth-camera", o.depth.camera,
                 "With --surfaces depth: name of the depth camera, for a rig with several");
  add_parsed(app, "--depth-scale", into(o.depth.metres_per_unit, parse_depth_scale),
             "Unit of the 16-bit values of a depth image, where the sensor does not state it (default: "
             "1mm)");
  add_parsed(app, "--depth-delay", into(o.depth.delay_s, io::parse_delay),
             "Time from the exposure of a depth image to its arrival, e.g. 30ms");
  add_parsed(
      app, "--up", [&](const std::string& text) { o.depth.up = io::parse_direction(text); },
      "Upward direction in the world, x,y,z (default: 0,0,1; without poses 0,-1,0 in the frame of "
      "the rig)");
  app.add_flag("--silhouettes", o.depth.silhouettes,
               "With --surfaces depth: no light on objects in front of the room, nor on people; all dark "
               "while no depth image arrives");
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
      "Content of a surface: an image, a folder or pattern of images, a video, camera:0, ros2:/TOPIC, "
      "log:FILE+/TOPIC, shm:NAME, height:colours[,range=-50mm..80mm][,contours=20mm] of a live shape, "
      "#rrggbb (default: as in the surface file)");
}

void declare_poses(CLI::App& app, show::ShowOptions& o) {
  CLI::Option* sources = app.add_option(
      "--pose-source", o.poses,
      "Source of poses: udp:9000, tcp:HOST:PORT, tcp-listen:PORT, osc:PORT, psn:PORT, "
      "rosbridge:HOST:PORT, ros2:map,base_link, ros2:/TOPIC, log:FILE; angles of a pan-tilt head: "
      "pan-tilt:udp:9000 (or tcp, tcp-listen, log), with its --mount; of a log of ROS 2: "
      "log:FILE+map,base_link, log:FILE+/TOPIC");
  const auto marker = [&](const char* flag, std::string show::MarkerInput::*member, const char* help) {
    return app.add_option_function<std::string>(
        flag, [&o, member](const std::string& text) { marker_of(o).*member = text; }, help);
  };
  CLI::Option* camera =
      marker("--marker-camera", &show::MarkerInput::camera,
             "Poses from markers in the image of the camera of the rig: its number, device or "
             "URL, ros2:/TOPIC, log:FILE+/TOPIC or watch:FOLDER")
          ->excludes(sources);
  marker("--marker", &show::MarkerInput::marker,
         "The marker that defines the world frame: DICTIONARY:ID:SIZE, e.g. apriltag_36h11:3:160mm")
      ->needs(camera);
  marker("--markers", &show::MarkerInput::markers,
         "markers.json: several markers with their poses in the world")
      ->needs(camera);
  marker("--marker-camera-name", &show::MarkerInput::name,
         "Name of that camera, for a rig with several cameras")
      ->needs(camera);
  app.add_option("--pose", o.pose,
                 "pose.json of a projector that does not move, instead of a source of poses");
  app.add_option("--mount", o.mount,
                 "pose.json of the rig, its projector or a camera in the moving frame of the poses ('base'); "
                 "default: the moving frame is the rig");
  app.add_option("--frame", o.frame,
                 "Parent frame of the poses; it is the world frame of the surfaces (default: the first "
                 "received)");
  app.add_option("--child", o.child, "Moving frame of the poses (default: the first received)");
  app.add_option("--predict", o.prediction,
                 "How poses are predicted to the time of light: auto, twist, acceleration or none")
      ->capture_default_str();
  add_parsed(app, "--source-delay", into(o.source_delay_s, io::parse_delay),
             "Shortest time from the measurement of a pose to its arrival, e.g. 40ms");
  add_parsed(app, "--blank-on-stale", into(o.blank_on_stale_s, io::parse_duration),
             "Show black when no pose has arrived for this time, e.g. 500ms");
  add_parsed(app, "--freeze-on-stale", into(o.freeze_on_stale_s, io::parse_duration),
             "Keep the last position when no pose has arrived for this time (default: 500ms)");
}

void declare_people(CLI::App& app, show::ShowOptions& o) {
  CLI::Option* people = app.add_option_function<std::string>(
      "--people", [&](const std::string& text) { people_of(o).source = text; },
      "Source of skeletons of people in front of the projector; their heads are kept dark: "
      "udp:9100, tcp:HOST:PORT, tcp-listen:PORT, vmc:39539, log:FILE");
  app.add_option_function<std::string>(
         "--sensor", [&](const std::string& text) { people_of(o).sensor = text; },
         "pose.json between the sensor of the people ('sensor') and the rig, its projector, a camera "
         "or the world")
      ->needs(people);
  add_parsed(
      app, "--sensor-delay", [&](const std::string& text) { people_of(o).delay_s = io::parse_delay(text); },
      "Shortest time from the measurement of a skeleton to its arrival, e.g. 50ms")
      ->needs(people);
  app.add_option_function<std::vector<std::string>>(
         "--people-to", [&](const std::vector<std::string>& list) { people_of(o).destinations = list; },
         "SURFACE=udp:HOST:PORT: send the skeletons, in metres on that surface, to the program that "
         "draws its content")
      ->needs(people);
}

void declare_watched_pose(CLI::App& app, const std::function<show::WatchInput&()>& watch,
                          CLI::Option* camera) {
  CLI::Option* pose = add_parsed(
      app, "--watch-pose",
      [watch](const std::string& text) {
        const io::LengthAndAngle sigma = io::parse_length_and_angle(text);
        watch().pose_m = sigma.length;
        watch().pose_rad = sigma.angle;
      },
      "Correct the localiser's poses by what it sees on surfaces in the world: standard deviation of their error, "
      "e.g. 20mm,1deg");
  pose->needs(camera);
  add_parsed(
      app, "--watch-pose-time",
      [watch](const std::string& text) { watch().pose_time_s = io::parse_duration(text); },
      "Time for which such an error lasts (3s)")
      ->needs(pose);
  app.add_option_function<std::string>(
         "--watch-markers", [watch](const std::string& text) { watch().markers = text; },
         "markers.json of known markers in the world, which show where the rig is along a wall")
      ->needs(pose);
}

void declare_watch(CLI::App& app, show::ShowOptions& o) {
  const auto watch = [&o]() -> show::WatchInput& { return o.watch ? *o.watch : o.watch.emplace(); };
  CLI::Option* camera = app.add_option_function<std::string>(
      "--watch", [watch](const std::string& text) { watch().camera = text; },
      "Camera of the rig that watches where the light is, without a pattern: camera:0, a device, a URL, "
      "ros2:/TOPIC or watch:FOLDER (docs/watch.md)");
  app.add_flag_callback(
         "--watch-only", [watch] { watch().only = true; },
         "Report what it finds, and correct nothing until the control page asks for it")
      ->needs(camera);
  app.add_flag_callback(
         "--marks", [watch] { watch().marks = true; },
         "Draw small marks on the surfaces where the content has no texture that could be watched")
      ->needs(camera);
  app.add_option_function<std::string>(
         "--watch-save", [watch](const std::string& text) { watch().save = text; },
         "Write the rig with the corrected projector to this file after each correction")
      ->needs(camera);
  app.add_option_function<std::string>(
         "--watch-name", [watch](const std::string& text) { watch().name = text; },
         "Name of that camera, for a rig with several cameras")
      ->needs(camera);
  add_parsed(
      app, "--watch-delay", [watch](const std::string& text) { watch().delay_s = io::parse_delay(text); },
      "Time from the exposure of its image to its arrival, e.g. 40ms")
      ->needs(camera);
  declare_watched_pose(app, watch, camera);
}

/// SURFACE=VALUE, several.
void take_pairs(const char* flag, const std::vector<std::string>& items,
                std::map<std::string, std::string>& into, const char* example) {
  for (const std::string& item : items) {
    const std::size_t equals = item.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == item.size())
      throw Error(ErrorKind::kInput, flag + (" " + item), "it does not read SURFACE=VALUE",
                  std::string("write e.g. ") + example);
    into[item.substr(0, equals)] = item.substr(equals + 1);
  }
}

void declare_track(CLI::App& app, show::ShowOptions& o) {
  const auto track = [&o]() -> show::TrackInput& { return o.track ? *o.track : o.track.emplace(); };
  CLI::Option* camera = app.add_option_function<std::string>(
      "--track-camera", [track](const std::string& text) { track().camera = text; },
      "Camera of the rig that sees the markers of surfaces that move: camera:0, a device, a URL, ros2:/TOPIC or "
      "watch:FOLDER (docs/tracked-surfaces.md)");
  CLI::Option* surfaces = app.add_option_function<std::vector<std::string>>(
      "--track",
      [track](const std::vector<std::string>& items) {
        take_pairs("--track", items, track().surfaces, "--track cart=apriltag_36h11:5:120mm");
      },
      "Surface that moves, and the markers on it: one, DICTIONARY:ID:SIZE, whose middle is the surface's origin, or a "
      "markers.json in the frame of the surface. Surfaces that move as one: cart,sign=MARKERS");
  surfaces->needs(camera);
  camera->needs(surfaces);
  app.add_option_function<std::vector<std::string>>(
         "--track-hinge",
         [track](const std::vector<std::string>& items) {
           take_pairs("--track-hinge", items, track().hinges, "--track-hinge door=left");
         },
         "Edge of the content about which a tracked surface rotates, as a door: left, right, top or bottom")
      ->needs(surfaces);
  app.add_option_function<std::string>(
         "--track-camera-name", [track](const std::string& text) { track().name = text; },
         "Name of that camera, for a rig with several cameras")
      ->needs(camera);
  add_parsed(
      app, "--track-delay", [track](const std::string& text) { track().delay_s = io::parse_delay(text); },
      "Time from the exposure of the middle row of its image to its arrival, e.g. 40ms")
      ->needs(camera);
  add_parsed(
      app, "--track-readout", [track](const std::string& text) { track().readout_s = io::parse_delay(text); },
      "Rolling shutter: time from the exposure of the first row to that of the last, e.g. 20ms")
      ->needs(camera);
  app.add_option_function<int>(
         "--marker-light", [track](int value) { track().marker_light = value; },
         "Grey value of the light on these markers, 0 to 255 (default: that of --search-light, else the content)")
      ->check(CLI::Range(0, 255))
      ->needs(camera);
  app.add_option_function<int>(
         "--search-light", [track](int value) { track().search_light = value; },
         "Grey value of the light around the surfaces while a tracked one is not seen, 1 to 255: for dark rooms "
         "(default: none)")
      ->check(CLI::Range(1, 255))
      ->needs(camera);
}

void declare_show_blend(CLI::App& app, show::ShowOptions& o) {
  const auto blend = [&o]() -> show::BlendSettings& { return o.blend ? *o.blend : o.blend.emplace(); };
  app.add_option_function<std::vector<std::string>>(
      "--blend", [blend](const std::vector<std::string>& names) { blend().projectors = names; },
      "Another projector of the rig that lights the same surfaces, once for each, or all: each shows its share of "
      "the light. The hosts of a --group blend without it; off: they do not");
  declare_blend_levels(
      app, {[blend](const std::vector<std::string>& items) {
              blend().brightness =
                  named_numbers("--brightness", items, kMinBrightness, kMaxBrightness, "left=2200");
            },
            [blend](const std::vector<std::string>& items) {
              blend().black = named_numbers("--black", items, 0, kMaxBlack, "left=0.001");
            },
            [blend](double share) { blend().compensate = share; }, [blend] { blend().one_level = true; }});
}

void declare_display(CLI::App& app, show::ShowOptions& o) {
  app.add_option("--display", o.display,
                 "Display for the full-screen window: number, name or position on the desktop ('1920,0')");
  app.add_option("--output", o.output,
                 "Output instead of a display: frames:FOLDER, video:FILE, stdout, shm:NAME or none");
  app.add_option_function<std::vector<std::string>>(
      "--screen",
      [&o](const std::vector<std::string>& items) {
        o.screens.clear();
        for (const std::string& item : items) o.screens.push_back(show::parse_screen(item));
      },
      "One of several projectors of the rig and its display, left=1, once for each; all show the same and blend. "
      "Instead of --projector and --display or --output");
  app.add_option(
      "--camera", o.delay_camera,
      "Camera that sees the projection; it measures the delay before the show: its number, device or "
      "URL, or ros2:/TOPIC");
  add_parsed(
      app, "--size", [&](const std::string& text) { o.size = io::parse_size(text); },
      "Size of the frame, e.g. 1280x800, where neither --rig nor a display gives it");
  add_parsed(
      app, "--delay",
      [&](const std::string& text) {
        if (text != "auto") {
          o.delay_s = io::parse_delay(text);
          o.delay_camera.clear();
        } else if (o.delay_camera.empty()) {
          throw Error(ErrorKind::kInput, "--delay auto", "no camera looks at the light",
                      "give --camera, or the delay");
        }
      },
      "Time from the start of drawing a frame to its light, e.g. 35ms; auto: measured with --camera "
      "(default: 0ms)");
  add_parsed(app, "--camera-delay", into(o.camera_delay_s, io::parse_delay),
             "Delay of the camera itself, subtracted from the measured delay");
  app.add_option("--fps", o.fps, "Frames a second (default: rate of the display, or 60)")
      ->check(within(0.1, 1000));
}

void declare_running(CLI::App& app, show::ShowOptions& o) {
  add_parsed(app, "--duration", into(o.duration_s, io::parse_duration), "End after this time, e.g. 30s");
  app.add_flag("--autosave", o.autosave,
               "Save edits of the control page to the surfaces file within a second");
  app.add_option("--record", o.record,
                 "Record the run in this log, for --replay; run.mcap: as messages of ROS 2");
  app.add_option("--control", o.control, "[ADDRESS:]PORT of the control page, or off")->capture_default_str();
  app.add_option("--token", o.token, "Secret of the control page (default: a new one)");
}

void declare_network(CLI::App& app, show::ShowOptions& o) {
  app.add_option(
      "--publish", o.publish,
      "ros2:[NAMESPACE]: publish the projector in the ROS 2 graph: CameraInfo, markers, and the frames of the rig "
      "and the surfaces on /tf_static");
  app.add_option(
      "--dds-security", o.dds_security,
      "Folder with the certificates of DDS Security, as ros2 security create_enclave writes it: for all "
      "ros2: and groups and fleets");
  CLI::Option* group = app.add_option(
      "--group", o.group,
      "Name of a group of hosts that show the same: one state, one clock of contents, one leader (docs/live.md)");
  group->check([](const std::string& name) { return name.empty() ? "the group's name is empty" : ""; });
  app.add_option("--group-strength", o.group_strength,
                 "When the leader is gone, the host with the greatest number leads: -1000 to 1000")
      ->check(CLI::Range(-1000, 1000))
      ->needs(group);
  CLI::Option* fleet = app.add_option(
      "--fleet", o.fleet,
      "Name of a fleet of robots that light one room: each surface is lit by one of them (docs/live.md)");
  CLI::Option* robot = app.add_option("--robot", o.robot, "Name of this robot in the fleet")->needs(fleet);
  fleet->needs(robot);
  app.add_option(
         "--priority", o.fleet_priority,
         "Of the robots that can light a surface, the one with the greatest number does: -1000 to 1000")
      ->check(CLI::Range(-1000, 1000))
      ->needs(fleet);
  app.add_flag("--fleet-blend", o.fleet_blend,
               "Light surfaces together with other robots of the fleet that have this flag")
      ->needs(fleet);
}

void declare_drawing(CLI::App& app, show::ShowOptions& o) {
  app.add_option("--threads", o.threads, "Number of threads; 0: one for each core")
      ->check(CLI::Range(0, limits::kThreads));
  app.add_option("--renderer", o.renderer, "cpu, or gl for OpenGL: the same frame")
      ->check(CLI::IsMember({"cpu", "gl"}))
      ->capture_default_str();
  app.add_flag("--bilinear", o.bilinear,
               "One sample for each pixel: faster, with aliasing where content is minified");
  app.add_flag("--average-numbers", o.average_numbers, "Average pixel values instead of light");
}

}  // namespace

void declare_show(CLI::App& app, show::ShowOptions& options) {
  declare_group(app, "Rig and surfaces", [&] {
    // The first one: options take effect in the order in which they are declared.
    app.add_option_function<std::string>(
        "--show", [&](const std::string& file) { options = show::load_options(file); },
        "show.json with the options below (docs/live.md); options on the command line override it");
    app.add_option("--projector", options.projector, "Name of the device, for a rig with several");
    declare_surfaces(app, options);
  });
  declare_group(app, "Display and timing", [&] { declare_display(app, options); });
  declare_group(app, "Running", [&] { declare_running(app, options); });
  declare_group(app, "Poses of a moving rig", [&] { declare_poses(app, options); });
  declare_group(app, "Surfaces that move", [&] { declare_track(app, options); });
  declare_group(app, "People", [&] { declare_people(app, options); });
  declare_group(app, "Watching the light", [&] { declare_watch(app, options); });
  declare_group(app, "Several projectors", [&] { declare_show_blend(app, options); });
  declare_group(app, "Networks and fleets", [&] { declare_network(app, options); });
  declare_group(app, "Drawing", [&] { declare_drawing(app, options); });
}

}  // namespace procam::tools
