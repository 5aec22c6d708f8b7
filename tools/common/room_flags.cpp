#include "common/room_flags.hpp"

#include <CLI/CLI.hpp>
#include <cmath>

#include "common/cli.hpp"
#include "common/light_flags.hpp"
#include "procam/core/base/words.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/exchange/calibration_file.hpp"
#include "procam/io/marker_map_file.hpp"

namespace procam::tools {
namespace {

/// "NAME=VALUE" or "VALUE"; an empty name stands for the only device.
std::pair<std::string, std::string> named(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) return {"", text};
  return {text.substr(0, equals), text.substr(equals + 1)};
}

std::string device_name(const std::string& name, const std::vector<Device>& devices,
                        const std::string& flag) {
  if (!name.empty()) return name;
  if (devices.size() == 1) return devices.front().name;
  throw Error(
      ErrorKind::kInput, flag, "the session has several such devices",
      "use which one, NAME=VALUE, of: " + comma_list(devices, [](const Device& d) { return d.name; }));
}

std::optional<Vec2> pixel_in(const std::string& text) {
  const std::size_t comma = text.find(',');
  if (comma == std::string::npos) return std::nullopt;
  return Vec2(io::parse_uncertain(text.substr(0, comma)).value,
              io::parse_uncertain(text.substr(comma + 1)).value);
}

/// "0.5%" or "0.005" as 0.005.
double parse_share(const std::string& text) {
  const bool is_percent = !text.empty() && text.back() == '%';
  const double value = io::parse_uncertain(is_percent ? text.substr(0, text.size() - 1) : text).value;
  const double share = is_percent ? value / 100 : value;
  if (!(share >= 0 && share <= 0.5))
    throw Error(ErrorKind::kInput, "'" + text + "'", "it is no share between 0 and 50 %", "give e.g. 0.5%");
  return share;
}

room::Estimate estimate(const io::Uncertain& value, double sigma) {
  return {value.value, value.sigma > 0 ? value.sigma : sigma};
}

/// The cameras of one --known-camera, by the names that they have in the session.
void add_known(const std::string& flag, const std::vector<Device>& cameras,
               const std::optional<double>& sigma, std::map<std::string, room::CameraLens>& known) {
  const auto [name, file] = named(flag);
  io::CalibrationContext context;
  context.camera_size = cameras.front().size;
  const Rig rig = io::load_calibration(file, context);
  const auto take = [&](const std::string& session_name, const RigCamera& camera) {
    room::CameraLens lens{camera.camera, {}, sigma};
    std::vector<std::string> rows;
    for (const std::string& parameter : parameter_names(camera.camera))
      if (rig.covariance.sigma(camera.name + "." + parameter) > 0) {
        lens.covariance.names.push_back(parameter);
        rows.push_back(camera.name + "." + parameter);
      }
    lens.covariance.matrix = rig.covariance.block(rows);
    known[session_name] = lens;
  };
  if (!name.empty() || cameras.size() == 1) {
    const std::string wanted = name.empty() ? cameras.front().name : name;
    take(wanted, rig.cameras.size() == 1 ? rig.cameras.front() : rig.camera(wanted));
    return;
  }
  for (const Device& camera : cameras) take(camera.name, rig.camera(camera.name));
}

}  // namespace

DistanceFlag parse_distance(const std::string& text) {
  const std::size_t first = text.find(':'), last = text.rfind(':');
  if (first == std::string::npos || first == last)
    throw Error(
        ErrorKind::kInput, "'" + text + "'", "a distance has two ends and a length",
        "give e.g. 412,300:880,310:1.25m, two pixels of the first view's image, or camera:projector:0.4m");
  DistanceFlag out;
  out.text = text;
  const std::string ends[] = {text.substr(0, first), text.substr(first + 1, last - first - 1)};
  for (const std::string& end : ends) {
    if (const std::optional<Vec2> pixel = pixel_in(end))
      out.pixels.push_back(*pixel);
    else
      out.devices.push_back(end);
  }
  if (out.pixels.size() == 1)
    throw Error(ErrorKind::kInput, "'" + text + "'", "one end is a pixel and the other a device",
                "give two pixels, or two devices");
  std::string length = text.substr(last + 1);
  const std::size_t sign = length.find("+-");
  if (sign != std::string::npos) {
    out.sigma = io::parse_length(length.substr(sign + 2));
    length.resize(sign);
  } else {
    out.sigma = out.pixels.empty() ? 5e-3 : 2e-3;
  }
  out.length = io::parse_length(length);
  if (!(out.length > 0) || !(out.sigma >= 0))
    throw Error(ErrorKind::kInput, "'" + text + "'", "the length is not positive",
                "give a length above zero, e.g. 1.25m");
  return out;
}

void declare_room(CLI::App& app, RoomFlags& flags) {
  app.add_option(
         "--captures", flags.captures,
         "Folder of views, each a sub-folder of numbered frames as for scan-surfaces. Between the views the "
         "cameras are moved; "
         "the projectors stand still")
      ->required();
  app.add_option(
      "--known-camera", flags.known_cameras,
      "Lens of the camera: a rig file of calibrate-camera, or another program's calibration "
      "(docs/exchange.md). Of several "
      "cameras NAME=FILE for each, or one file with all. Without it the lens is estimated from the room, "
      "less certainly, with the focal length in the images' EXIF (+-10%) where they have one");
  add_parsed(
      app, "--lens-sigma", [&](const std::string& text) { flags.lens_sigma = parse_share(text); },
      "Deviation of a --known-camera whose file has no covariance, as a share of its focal length: 0.5%, or 0 for an "
      "exact lens. Without it such a lens is kept while the light agrees, and may be off as a data sheet's, by 10%");
  add_parsed(
      app, "--distance", [&](const std::string& text) { flags.distances.push_back(parse_distance(text)); },
      "A known length, which gives the scale: two pixels of the first view's image and how far apart their "
      "points of the walls are, "
      "412,300:880,310:1.25m or with its deviation 1.25m+-1mm (default 2mm); or two devices' lenses, "
      "camera:projector:0.4m "
      "(default +-5mm). Several are averaged by their certainty")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  add_parsed(
      app, "--marker", [&](const std::string& text) { flags.marker = io::parse_marker(text); },
      "Scale from a printed marker that stands still while two camera positions see it: DICTIONARY:ID:SIZE, the side of "
      "the black square, e.g. apriltag_36h11:3:160mm");
  add_parsed(
      app, "--board", [&](const std::string& text) { flags.board = io::read_board(text); },
      "Scale from a printed board that stands still while two camera positions see it, e.g. charuco:6x5:60mm:45mm:4x4_50");
  app.callback([&app] {
    for (const char* name : {"--distance", "--marker", "--board"})
      if (app.count(name) > 0) return;
    throw CLI::RequiredError("--distance, --marker or --board: light tells no length, so one of them");
  });
  app.add_option(
      "--throw-ratio", flags.throw_ratios,
      "Known of the projector: distance over image width, e.g. 1.4 or 1.4+-0.02; of several projectors NAME=1.4");
  app.add_option(
      "--lens-shift", flags.lens_shifts,
      "Known of the projector: how far its axis is from the centre of the image, in widths and heights, "
      "right and down, e.g. "
      "0,0.5 or 0+-0.01,0.5+-0.02; of several projectors NAME=0,0.5");
  declare_light(app, flags.open);
  app.add_option("--points-per-view", flags.points_a_map,
                 "Points of the walls that each view and projector adds")
      ->check(CLI::Range(100, 100000))
      ->capture_default_str();
  app.add_option("-o,--output", flags.output, "rig.json to write")->required();
  app.add_option("--save-points", flags.points,
                 "Also write the points of the walls with standard deviations, .ply or .pcd");
  app.add_option("--preview", flags.preview,
                 "Also draw the room from above and from the side with the devices, .png");
  app.add_option("--truth", flags.truth,
                 "A rig file known to be true (a simulation's): report the distance to it");
}

std::vector<room::MarkedPixel> marked_pixels(const RoomFlags& flags) {
  std::vector<room::MarkedPixel> marked;
  for (const DistanceFlag& distance : flags.distances)
    for (const Vec2& pixel : distance.pixels) marked.push_back({"", "", pixel});
  return marked;
}

room::RoomOptions room_options(const RoomFlags& flags, const room::RoomPoints& points) {
  constexpr double kSheet = 0.02;  // data sheets round
  room::RoomOptions options;
  for (const std::string& flag : flags.known_cameras)
    add_known(flag, points.cameras, flags.lens_sigma, options.cameras);
  for (const std::string& flag : flags.throw_ratios) {
    const auto [name, value] = named(flag);
    const io::Uncertain ratio = io::parse_uncertain(value);
    if (!(ratio.value > 0))
      throw Error(ErrorKind::kInput, "--throw-ratio " + flag, "it is not positive",
                  "give distance over width, e.g. 1.4+-0.02");
    options.projectors[device_name(name, points.projectors, "--throw-ratio")].throw_ratio =
        estimate(ratio, kSheet * ratio.value);
  }
  for (const std::string& flag : flags.lens_shifts) {
    const auto [name, value] = named(flag);
    const std::size_t comma = value.find(',');
    if (comma == std::string::npos)
      throw Error(ErrorKind::kInput, "--lens-shift " + flag, "it needs two numbers", "give e.g. 0,0.5");
    room::LensSheet& sheet = options.projectors[device_name(name, points.projectors, "--lens-shift")];
    sheet.shift_x = estimate(io::parse_uncertain(value.substr(0, comma)), kSheet);
    sheet.shift_y = estimate(io::parse_uncertain(value.substr(comma + 1)), kSheet);
  }
  std::size_t next = 0;
  for (const DistanceFlag& distance : flags.distances) {
    room::KnownDistance known;
    known.devices = distance.devices;
    known.length = distance.length;
    known.sigma = distance.sigma;
    for (std::size_t i = 0; i < distance.pixels.size(); ++i) known.points.push_back(points.marked[next++]);
    options.distances.push_back(std::move(known));
  }
  return options;
}

std::map<std::string, room::CameraSheet> camera_sheets(const std::vector<CameraExif>& exif,
                                                       Diagnostics& remarks) {
  constexpr double kSameLens = 0.01;
  std::map<std::string, const CameraExif*> first;
  std::map<std::string, room::CameraSheet> sheets;
  for (const CameraExif& seen : exif) {
    const std::string name = seen.camera.empty() ? "camera" : seen.camera;
    const auto [at, is_first] = first.try_emplace(name, &seen);
    const io::ExifFocal& focal = seen.focal;
    if (is_first) {
      sheets[name] = {{focal.focal_px, focal.sigma_share * focal.focal_px},
                      "the images' EXIF (" + focal.description() + ")"};
    } else if (std::abs(focal.focal_px / at->second->focal.focal_px - 1) > kSameLens &&
               sheets.erase(name) > 0) {
      remarks.warn("exif_changes", "camera '" + name + "': the images' EXIF has " +
                                       at->second->focal.description() + " in view '" + at->second->view +
                                       "' and " + focal.description() + " in '" + seen.view +
                                       "'; it is not used. A lens that zooms needs a fixed setting");
    }
  }
  return sheets;
}

std::map<std::string, std::string> given_options(const RoomFlags& flags) {
  std::map<std::string, std::string> given;
  const auto add = [&](const std::string& name, const std::vector<std::string>& values) {
    if (!values.empty()) given[name] = comma_list(values);
  };
  add("known-camera", flags.known_cameras);
  if (flags.lens_sigma) given["lens-sigma"] = shortest(*flags.lens_sigma);
  add("throw-ratio", flags.throw_ratios);
  add("lens-shift", flags.lens_shifts);
  if (!flags.distances.empty())
    given["distance"] = comma_list(flags.distances, [](const DistanceFlag& d) { return d.text; });
  return given;
}

}  // namespace procam::tools
