#include "procam/show/show_options.hpp"

#include <algorithm>

#include "document/fields.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/device/content_source.hpp"

namespace procam::show {

// Field lists are found by the namespace of their noun, so that they are not in the unnamed one.

static constexpr const char* kDepth = "depth:";
static constexpr const char* kShape = "depth-shape:";

/// A field that may be missing where it has its default.
template <typename T>
static void field_or(io::Fields& f, const char* name, T& value, const T& usual) {
  std::optional<T> other;
  if (!f.reading() && !(value == usual)) other = value;
  f.optional(name, other);
  if (f.reading() && other) value = *other;
}

static void fields(io::Fields& f, MarkerInput& marker) {
  f.field("camera", marker.camera);
  f.optional("name", marker.name);
  f.optional("marker", marker.marker);
  f.optional("markers", marker.markers);
  f.check(marker.marker.empty() != marker.markers.empty(), "camera",
          "one of 'marker' and 'markers' is needed",
          "give a marker, e.g. apriltag_36h11:3:160mm, or a marker map file");
}

static void fields(io::Fields& f, DepthInput& depth) {
  const DepthInput usual;
  f.optional("camera", depth.camera);
  field_or(f, "metres_per_unit", depth.metres_per_unit, usual.metres_per_unit);
  field_or(f, "delay_s", depth.delay_s, usual.delay_s);
  f.optional("up", depth.up);
  field_or(f, "silhouettes", depth.silhouettes, usual.silhouettes);
  f.check(depth.metres_per_unit > 0 && depth.metres_per_unit < 1, "metres_per_unit",
          "one step of a depth image cannot be that long", "give it in metres, e.g. 0.001");
  f.check(depth.delay_s >= 0 && depth.delay_s <= limits::kDelayS, "delay_s", "no camera is that late",
          "give seconds, e.g. 0.03");
  f.check(!depth.up || depth.up->norm() > 1e-6, "up", "it is not a direction",
          "give three numbers: [0, 0, 1]");
}

static void fields(io::Fields& f, PeopleInput& people) {
  f.field("source", people.source);
  f.field("sensor", people.sensor);
  field_or(f, "delay_s", people.delay_s, 0.0);
  f.optional("destinations", people.destinations);
  f.check(people.delay_s >= 0 && people.delay_s <= limits::kDelayS, "delay_s", "no sensor is that late",
          "give seconds, e.g. 0.05");
}

static void fields(io::Fields& f, WatchInput& watch) {
  f.field("camera", watch.camera);
  f.optional("name", watch.name);
  field_or(f, "delay_s", watch.delay_s, 0.0);
  field_or(f, "only", watch.only, false);
  field_or(f, "marks", watch.marks, false);
  field_or(f, "save", watch.save, std::string());
  const WatchInput usual;
  field_or(f, "pose_m", watch.pose_m, usual.pose_m);
  field_or(f, "pose_rad", watch.pose_rad, usual.pose_rad);
  field_or(f, "pose_time_s", watch.pose_time_s, usual.pose_time_s);
  field_or(f, "markers", watch.markers, std::string());
  f.check(watch.pose_m >= 0 && watch.pose_m <= 1 && watch.pose_rad > 0 && watch.pose_rad <= 0.5, "pose_m",
          "no localiser is off by that", "give metres and radians, e.g. 0.02 and 0.0175");
  f.check(watch.pose_time_s > 0 && watch.pose_time_s <= 3600, "pose_time_s",
          "an error of a localiser does not last so long", "give seconds, e.g. 3");
  f.check(watch.delay_s >= 0 && watch.delay_s <= limits::kDelayS, "delay_s", "no camera is that late",
          "give seconds, e.g. 0.05");
}

static void fields(io::Fields& f, TrackInput& track) {
  f.field("camera", track.camera);
  f.optional("name", track.name);
  field_or(f, "delay_s", track.delay_s, 0.0);
  field_or(f, "readout_s", track.readout_s, 0.0);
  f.map("surfaces", track.surfaces);
  if (f.reading() ? f.has("hinges") : !track.hinges.empty()) f.map("hinges", track.hinges);
  field_or(f, "marker_light", track.marker_light, TrackInput().marker_light);
  field_or(f, "search_light", track.search_light, TrackInput().search_light);
  f.check(track.delay_s >= 0 && track.delay_s <= limits::kDelayS, "delay_s", "no camera is that late",
          "give seconds, e.g. 0.05");
  f.check(track.readout_s >= 0 && track.readout_s <= limits::kDelayS, "readout_s", "no camera is that slow",
          "give seconds, e.g. 0.02");
  f.check(track.marker_light >= -1 && track.marker_light <= 255, "marker_light", "it is not from 0 to 255",
          "give a grey value, or -1 for the light of the content");
  f.check(track.search_light >= 0 && track.search_light <= 255, "search_light", "it is not from 0 to 255",
          "give a grey value, or 0 for none");
}

static void fields(io::Fields& f, BlendSettings& blend) {
  f.optional("projectors", blend.projectors);
  for (auto* by_projector : {&blend.black, &blend.brightness}) {
    const char* const name = by_projector == &blend.black ? "black" : "brightness";
    if (f.reading() ? f.has(name) : !by_projector->empty()) f.map(name, *by_projector);
  }
  field_or(f, "compensate", blend.compensate, 0.0);
  field_or(f, "one_level", blend.one_level, false);
  for (const auto& [name, ratio] : blend.black)
    f.check(ratio >= 0 && ratio <= 0.5, "black", "that of '" + name + "' is not from 0 to 0.5",
            "give the light of black over that of white, e.g. 0.001");
  for (const auto& [name, light] : blend.brightness)
    f.check(light >= 1e-6 && light <= 1e9, "brightness", "that of '" + name + "' is not from 1e-6 to 1e9",
            "give lumens, e.g. 2200");
  f.check(blend.compensate <= 0 || (blend.compensate >= 0.05 && blend.compensate <= 1), "compensate",
          "it is not from 0.05 to 1", "give the share of light that bright places keep, e.g. 0.3");
  f.check(blend.compensate > 0 || (!blend.one_level && blend.brightness.empty()), "compensate",
          "'brightness' and 'one_level' need it", "add e.g. \"compensate\": 0.3");
}

static void fields(io::Fields& f, ScreenOutput& screen) {
  f.field("projector", screen.projector);
  f.optional("display", screen.display);
  f.optional("output", screen.output);
  f.check(screen.display.has_value() != !screen.output.empty(), "display",
          "one of 'display' and 'output' is needed", "give the display's number, e.g. \"1\"");
}

static void check_times(io::Fields& f, const ShowOptions& o) {
  const auto check = [&](const char* name, const std::optional<double>& seconds, double max) {
    f.check(!seconds || (*seconds >= 0 && *seconds <= max), name,
            "it is not from 0 to " + std::to_string(int(max)) + " seconds", "give seconds, e.g. 0.03");
  };
  check("source_delay_s", o.source_delay_s, limits::kDelayS);
  check("delay_s", o.delay_s, limits::kDelayS);
  check("camera_delay_s", o.camera_delay_s, limits::kDelayS);
  check("blank_on_stale_s", o.blank_on_stale_s, limits::kDurationS);
  check("freeze_on_stale_s", o.freeze_on_stale_s, limits::kDurationS);
  check("duration_s", o.duration_s, limits::kDurationS);
}

static void fields(io::Fields& f, ShowOptions& o) {
  const ShowOptions usual;
  io::header(f, "procam-show", 1);
  f.optional("projector", o.projector);
  f.field("surfaces", o.surfaces);
  if (f.reading() ? f.has("contents") : !o.contents.empty()) f.map("contents", o.contents);
  f.optional("poses", o.poses);
  f.optional("marker", o.marker);
  f.optional("pose", o.pose);
  f.optional("mount", o.mount);
  f.optional("frame", o.frame);
  f.optional("child", o.child);
  field_or(f, "prediction", o.prediction, usual.prediction);
  field_or(f, "source_delay_s", o.source_delay_s, usual.source_delay_s);
  f.optional("blank_on_stale_s", o.blank_on_stale_s);
  f.optional("freeze_on_stale_s", o.freeze_on_stale_s);
  f.optional("display", o.display);
  f.optional("output", o.output);
  if (f.reading() ? f.has("screens") : !o.screens.empty()) f.list("screens", "screen", o.screens);
  f.optional("size", o.size);
  field_or(f, "fps", o.fps, usual.fps);
  field_or(f, "duration_s", o.duration_s, usual.duration_s);
  field_or(f, "delay_s", o.delay_s, usual.delay_s);
  f.optional("delay_camera", o.delay_camera);
  field_or(f, "camera_delay_s", o.camera_delay_s, usual.camera_delay_s);
  const bool has_depth = f.reading() ? f.has("depth") : is_depth_source(o.surfaces);
  if (has_depth) f.field("depth", o.depth);
  f.optional("people", o.people);
  f.optional("publish", o.publish);
  f.optional("dds_security", o.dds_security);
  f.optional("watch", o.watch);
  f.optional("track", o.track);
  f.optional("blend", o.blend);
  f.optional("group", o.group);
  field_or(f, "group_strength", o.group_strength, usual.group_strength);
  f.optional("fleet", o.fleet);
  f.optional("robot", o.robot);
  field_or(f, "fleet_priority", o.fleet_priority, usual.fleet_priority);
  field_or(f, "fleet_blend", o.fleet_blend, usual.fleet_blend);
  field_or(f, "autosave", o.autosave, usual.autosave);
  f.optional("record", o.record);
  field_or(f, "control", o.control, usual.control);
  f.optional("token", o.token);
  field_or(f, "renderer", o.renderer, usual.renderer);
  field_or(f, "threads", o.threads, usual.threads);
  field_or(f, "bilinear", o.bilinear, usual.bilinear);
  field_or(f, "average_numbers", o.average_numbers, usual.average_numbers);
  f.check(!o.surfaces.empty(), "surfaces", "it is empty", "name a surface file");
  f.check(o.fps >= 0 && o.fps <= 1000, "fps", "it is not from 0 to 1000", "give frames a second, e.g. 60");
  f.check(o.threads >= 0 && o.threads <= limits::kThreads, "threads",
          "it is not from 0 to " + std::to_string(limits::kThreads), "give 0 for as many as the machine has");
  f.check(o.group_strength >= -1000 && o.group_strength <= 1000, "group_strength",
          "it is not from -1000 to 1000", "give a whole number, e.g. 10");
  f.check(o.fleet_priority >= -1000 && o.fleet_priority <= 1000, "fleet_priority",
          "it is not from -1000 to 1000", "give a whole number, e.g. 10");
  f.check(o.fleet.empty() == o.robot.empty(), "robot", "'fleet' and 'robot' need each other",
          "give both, or none");
  check_times(f, o);
  f.check(o.renderer == "cpu" || o.renderer == "gl", "renderer", "there is none of this name",
          "use cpu or gl");
  f.check(!o.marker || o.poses.empty(), "marker", "poses come from 'poses' as well", "give one of them");
}

/// Every file name of the options, through `change`.
template <typename Change>
static void for_each_file(ShowOptions& o, const Change& change) {
  const auto apply = [&](std::string& file) {
    if (!file.empty()) file = change(file);
  };
  if (!is_depth_source(o.surfaces)) apply(o.surfaces);
  for (auto& item : o.contents)
    if (const auto file = device::content_file(item.second))
      item.second = device::with_content_file(item.second, change(*file));
  for (std::string* file : {&o.pose, &o.mount, &o.record, &o.dds_security}) apply(*file);
  if (o.marker) apply(o.marker->markers);
  if (o.watch) apply(o.watch->markers);
  if (o.people) apply(o.people->sensor);
  if (o.track)
    for (auto& item : o.track->surfaces)
      if (is_marker_file(item.second)) apply(item.second);
}

bool is_marker_file(const std::string& markers) {
  return std::count(markers.begin(), markers.end(), ':') != 2;
}

bool is_depth_source(const std::string& surfaces) {
  return surfaces.rfind(kDepth, 0) == 0 || is_shape_source(surfaces);
}

bool is_shape_source(const std::string& surfaces) {
  return surfaces.rfind(kShape, 0) == 0;
}

ScreenOutput parse_screen(const std::string& text) {
  const std::size_t sign = text.find('=');
  if (sign == 0 || sign == std::string::npos || sign + 1 == text.size())
    throw Error(ErrorKind::kInput, "screen '" + text + "'", "it is no projector and its display",
                "give for example left=1");
  ScreenOutput screen;
  screen.projector = text.substr(0, sign);
  const std::string place = text.substr(sign + 1);
  if (place == "none" || place == "stdout" || place.find(':') != std::string::npos)
    screen.output = place;
  else
    screen.display = place;
  return screen;
}

ShowOptions load_options(const std::filesystem::path& path) {
  auto options = io::load_noun<ShowOptions>(path, io::Syntax::kJson);
  for_each_file(options, [&](const std::string& file) {
    return (path.parent_path() / file).lexically_normal().string();
  });
  return options;
}

void save_options(const std::filesystem::path& path, const ShowOptions& options) {
  ShowOptions saved = options;
  const auto folder = std::filesystem::absolute(path).parent_path().lexically_normal();
  for_each_file(saved, [&](const std::string& file) {
    if (std::filesystem::path(file).is_absolute()) return file;
    return std::filesystem::absolute(file).lexically_normal().lexically_relative(folder).generic_string();
  });
  io::save_noun(path, io::Syntax::kJson, saved);
}

}  // namespace procam::show
