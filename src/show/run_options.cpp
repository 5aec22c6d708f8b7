#include "run_options.hpp"

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <set>

#include "depth_surfaces.hpp"
#include "height_content.hpp"
#include "procam/core/base/words.hpp"
#include "procam/core/rig/room_frames.hpp"
#include "procam/device/content_source.hpp"
#include "procam/io/files.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/render/gl.hpp"
#include "run_log.hpp"

namespace procam::show {
namespace {

namespace fs = std::filesystem;

std::shared_ptr<render::Renderer> renderer_for(const ShowOptions& options) {
  render::RenderOptions rendering;
  rendering.threads = options.threads;
  rendering.filter = options.bilinear ? render::Filter::kBilinear : render::Filter::kArea;
  rendering.linear_light = !options.average_numbers;
  return render_gl::open_renderer(options.renderer, rendering);
}

Pose load_mount(const std::string& file, const Rig& rig, const RigProjector& projector) {
  FrameTree::Link mount = io::load_mount(file).pose;
  const auto is_carrier = [](const std::string& frame) {
    return frame == "base" || frame == "flange" || frame == "tilt";
  };
  if (!is_carrier(mount.target) && !is_carrier(mount.source))
    throw Error(ErrorKind::kInput, file, "it does not tell where anything is on 'base', 'flange' or 'tilt'",
                "give a pose between 'base' and the rig, its projector or a camera");
  // room_frames() attaches a device's surroundings to the rig under the name "world".
  (is_carrier(mount.target) ? mount.target : mount.source) = "world";
  return room_frames(rig, projector, std::move(mount)).get("world", "rig").pose;
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

/// What is tracked, beyond the surfaces file.
std::string track_text(const ShowOptions& options) {
  if (!options.track) return "";
  char text[112];
  std::snprintf(text, sizeof text, ", tracked with delay %g s, marker light %d, search light %d",
                options.track->delay_s, options.track->marker_light, options.track->search_light);
  std::string words = text;
  for (const auto& [surfaces, markers] : options.track->surfaces)
    words += ", " + surfaces + " by " +
             (is_marker_file(markers) ? io::sha256_of_file(markers).substr(0, 16) : markers);
  return words;
}

MovingOptions moving_options(const ShowOptions& options, const track::TrackOptions& of_poses) {
  MovingOptions moving;
  if (!options.track) return moving;
  for (const auto& [names, markers] : options.track->surfaces)
    moving.surfaces.push_back({split_names(names), is_marker_file(markers) ? io::load_marker_map(markers)
                                                                           : io::parse_marker(markers)});
  moving.track.prediction = of_poses.prediction;
  moving.track.stale_after = of_poses.stale_after;
  moving.track.delay = options.track->delay_s;
  moving.marker_light = options.track->marker_light;
  moving.search_light = options.track->search_light;
  return moving;
}

/// What the maps of a blend depend on besides the surfaces and the projectors with light.
std::string blend_conditions(const ShowOptions& options) {
  if (!options.blend) return "";
  std::string text;
  for (const auto& [name, ratio] : options.blend->black) text += format(", black %s=%g", name.c_str(), ratio);
  if (options.blend->compensate <= 0) return text;
  for (const auto& [name, light] : options.blend->brightness)
    text += format(", brightness %s=%g", name.c_str(), light);
  return text + format(", compensate %g%s", options.blend->compensate,
                       options.blend->one_level ? " to one level" : "");
}

void check_screens(const ShowOptions& options) {
  const auto refuse = [](const std::string& why, const std::string& next) {
    throw Error(ErrorKind::kInput, "screens", why, next);
  };
  if (options.screens.empty()) return;
  if (options.screens.size() == 1)
    refuse("there is only one", "give two or more, or the options projector and display");
  std::set<std::string> names;
  for (const ScreenOutput& screen : options.screens)
    if (!names.insert(screen.projector).second)
      refuse("projector '" + screen.projector + "' has two", "name each projector once");
  if (!options.projector.empty() || options.display || !options.output.empty())
    refuse("projector, display and output are those of one screen", "leave them out");
  const std::pair<bool, const char*> needs_one[] = {
      {options.watch.has_value(), "watch"},
      {options.track.has_value(), "track"},
      {options.people.has_value(), "people"},
      {!options.publish.empty(), "publish"},
      {!options.fleet.empty(), "fleet"},
      {!options.record.empty(), "record"},
      {is_depth_source(options.surfaces), "surfaces of a depth camera"}};
  for (const auto& [given, name] : needs_one)
    if (given)
      refuse(std::string(name) + " is possible with one projector in a process only",
             "leave it out, or start a process for each projector");
}

void check_blend(const ShowOptions& options) {
  const auto refuse = [](const std::string& why, const std::string& next) {
    throw Error(ErrorKind::kInput, "blend", why, next);
  };
  if (!options.blend) return;
  const std::vector<std::string>& names = options.blend->projectors;
  const bool is_off = names == std::vector<std::string>{"off"};
  if (is_off) return;
  if (!options.group.empty() && !names.empty())
    refuse("in a group the hosts announce their projectors", "leave the names out, or give off");
  if (options.group.empty() && options.screens.empty() && names.empty())
    refuse("no other projector is named", "name the others of the rig, or all");
  if (is_depth_source(options.surfaces))
    refuse("the other projectors do not know the surfaces of this depth camera",
           "leave out --blend, or detect the surfaces before the show (detect-surfaces)");
  if (options.track)
    refuse("the surfaces that --track moves would need new maps in each frame",
           "leave out --blend or --track");
  if (!options.fleet.empty())
    refuse("which robots light a surface of a fleet changes, and their projectors are not in one rig",
           "leave out --blend or --fleet");
  if (options.blend->compensate <= 0 && (options.blend->one_level || !options.blend->brightness.empty()))
    refuse("brightness and one level need compensation", "add --compensate 0.3");
}

}  // namespace

std::vector<std::string> split_names(const std::string& names) {
  std::vector<std::string> list;
  for (std::size_t begin = 0; begin <= names.size();) {
    const std::size_t end = std::min(names.find(',', begin), names.size());
    list.push_back(names.substr(begin, end - begin));
    begin = end + 1;
  }
  return list;
}

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
  projection.moving = moving_options(options, projection.track);
  projection.marks = options.watch && options.watch->marks;
  projection.renderer = renderer_for(options);
  projection.threads = options.threads;
  return projection;
}

track::PoseCorrectionOptions pose_correction(const ShowOptions& options,
                                             const ProjectionOptions& projection) {
  track::PoseCorrectionOptions correction;
  correction.track = projection.track;
  correction.child_from_rig = projection.child_from_rig;
  correction.position_sigma = options.watch->pose_m;
  correction.rotation_sigma = options.watch->pose_rad;
  correction.correlation = options.watch->pose_time_s;
  return correction;
}

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
  return text + blend_conditions(options) + of_file("pose", options.pose) + of_file("mount", options.mount) +
         track_text(options);
}

ShowOptions of_first_screen(ShowOptions options) {
  if (options.screens.empty()) return options;
  const ScreenOutput& first = options.screens.front();
  options.projector = first.projector;
  options.display = first.display;
  options.output = first.output;
  return options;
}

ProjectionOptions of_side_screen(const ProjectionOptions& first, const ShowOptions& options, const Rig& rig,
                                 const std::string& projector) {
  ProjectionOptions side = first;
  side.projector = projector;
  side.renderer = renderer_for(options);  // it keeps pictures by numbers of one Projection
  if (first.projector_from_world)
    side.projector_from_world =
        (rig.projector(projector).rig_from_projector.inverse() *
         rig.projector(first.projector).rig_from_projector * *first.projector_from_world)
            .normalized();
  return side;
}

fs::path content_folder(const std::string& surfaces) {
  return surfaces.empty() || is_depth_source(surfaces) ? fs::current_path()
                                                       : fs::absolute(surfaces).parent_path();
}

std::map<std::string, std::string> absolute_contents(const ShowOptions& options) {
  std::map<std::string, std::string> contents = options.contents;
  for (auto& item : contents)
    item.second = device::content_beside(fs::current_path() / "show.json", item.second);
  return contents;
}

std::vector<std::string> content_choices(const fs::path& folder, const SurfaceSet& set) {
  std::vector<std::string> found = device::content_files(folder, 200);
  for (const Surface& surface : set.surfaces)
    if (!surface.content.empty() && std::find(found.begin(), found.end(), surface.content) == found.end())
      found.push_back(surface.content);
  for (const char* colour : {"#ffffff", "#ff0000", "#00ff00", "#0000ff"}) found.emplace_back(colour);
  return found;
}

static void check_track(const ShowOptions& options) {
  const auto refuse = [](const std::string& what, const std::string& why, const std::string& next) {
    throw Error(ErrorKind::kInput, what, why, next);
  };
  const TrackInput& track = *options.track;
  if (track.camera.empty()) refuse("track", "no camera looks at the surfaces", "give --track-camera");
  if (track.surfaces.empty())
    refuse("track", "no surface is named that the camera could look for", "give --track SURFACE=MARKERS");
  if (is_depth_source(options.surfaces))
    refuse("track", "the surfaces come from a depth camera, which tracks them itself",
           "give a surface file, or leave out --track");
  if (options.watch)
    refuse("watch", "light on a surface that moves does not show whether the projector has",
           "leave out --watch or --track");
  if (!options.group.empty())
    refuse("group", "the places of tracked surfaces are not sent to other hosts",
           "leave out --group or --track");
  std::set<std::string> names;
  for (const auto& [surfaces, markers] : track.surfaces)
    for (const std::string& name : split_names(surfaces))
      if (name.empty() || !names.insert(name).second)
        refuse("track '" + surfaces + "'", "it has an empty name, or one that is tracked twice",
               "name each surface once, those that move as one joined by commas");
  for (const auto& [surface, edge] : track.hinges) {
    if (track.surfaces.find(surface) == track.surfaces.end())
      refuse("hinge of '" + surface + "'", "no such surface is tracked",
             "give --track " + surface + "=MARKERS");
    if (edge != "left" && edge != "right" && edge != "top" && edge != "bottom")
      refuse("hinge of '" + surface + "'", "'" + edge + "' is no edge of its content",
             "use left, right, top or bottom");
  }
}

void check_combination(const ShowOptions& options) {
  const auto refuse = [](const std::string& what, const std::string& why, const std::string& next) {
    throw Error(ErrorKind::kInput, what, why, next);
  };
  if (options.surfaces.empty()) refuse("surfaces", "none are given", "name a surface file");
  check_screens(options);
  check_blend(options);
  if (options.people && !options.record.empty())
    refuse("record", "a run with people cannot be shown again bit for bit", "leave one of them out");
  if (options.watch && options.watch->only && !options.watch->save.empty())
    refuse("watch", "nothing is corrected that could be saved", "leave out --watch-only or --watch-save");
  if (options.watch && !options.watch->save.empty()) io::require_writable(options.watch->save);
  if (options.watch && options.watch->pose_m > 0 && options.poses.empty())
    refuse("watch pose", "no localiser is named whose poses could be corrected",
           "give --pose-source, or leave out --watch-pose");
  if (options.watch && options.watch->pose_m > 0 && !options.watch->save.empty())
    refuse("watch pose", "the robot's pose is corrected then, and not the rig", "leave out --watch-save");
  if (options.watch && options.watch->pose_m <= 0 && !options.watch->markers.empty())
    refuse("watch markers", "they correct the poses of a localiser, and none is to be corrected",
           "add --watch-pose 20mm,1deg, or leave out --watch-markers");
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
  if (options.fleet.empty() != options.robot.empty())
    refuse("fleet", "a fleet and the name of the robot in it need each other", "give --fleet and --robot");
  if (!options.fleet.empty() && is_depth_source(options.surfaces))
    refuse("fleet", "surfaces of a depth camera have names that other robots do not know",
           "leave out --fleet, or detect the surfaces before the show (detect-surfaces)");
  if (!options.fleet.empty() && !options.group.empty())
    refuse("fleet", "the hosts of a group show the same, and the robots of a fleet do not",
           "leave out --fleet or --group");
  if (options.fleet_blend && options.watch)
    refuse("fleet", "on a surface that several robots light, the camera sees the light of all of them",
           "leave out --watch or --fleet-blend");
  if (!options.fleet.empty() && !options.record.empty())
    refuse("record", "a run in a fleet cannot be shown again bit for bit", "leave one of them out");
  if (options.depth.silhouettes && !options.record.empty())
    refuse("record", "a run with silhouettes cannot be shown again bit for bit", "leave one of them out");
  if (options.track) check_track(options);
}

}  // namespace procam::show
