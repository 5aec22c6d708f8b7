/// scan-surfaces: captures of Gray code or phase shift + a rig -> points, a mesh, and surfaces.json.
#include <CLI/CLI.hpp>

#include "common/cli.hpp"
#include "common/light_flags.hpp"
#include "common/scan_files.hpp"
#include "common/station_flags.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/depth_file.hpp"
#include "procam/io/image/pfm.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/text.hpp"
#include "procam/report/scan.hpp"
#include "procam/session/light.hpp"

namespace procam::tools {
namespace {

namespace fs = std::filesystem;

struct Flags {
  std::vector<std::string> captures, truth;
  std::string view, rig, output, points, depth, preview;
  std::optional<Vec3> eye;
  session::OpenOptions open;
  scan::ScanOptions scan;
  StationFlags stations;  ///< with the options of meshes
};

void declare(CLI::App& app, Flags& flags) {
  app.add_option(
         "--captures", flags.captures,
         "Folder with a sub-folder of numbered frames, as capture-session and simulate-captures write it; no board "
         "is needed. Given several times: stations of the moved rig in one room, which are merged")
      ->required()
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--rig", flags.rig, "rig.json of the camera and projector, as calibrate-projector writes it")
      ->required();
  app.add_option("--view", flags.view, "Name of the sub-folder, where there are several");
  declare_light(app, flags.open);
  add_parsed(
      app, "--deviation",
      [&](const std::string& text) { flags.stations.merge.mesh.max_deviation = io::parse_length(text); },
      "Largest deviation of the mesh from the points (default 0.5mm, and never below their noise)");
  add_parsed(
      app, "--nearest", [&](const std::string& text) { flags.scan.nearest = io::parse_length(text); },
      "Depths below are rejected (default 0.05m)");
  add_parsed(
      app, "--farthest", [&](const std::string& text) { flags.scan.farthest = io::parse_length(text); },
      "Depths above are rejected (default 50m)");
  app.add_option(
         "-o,--output", flags.output,
         "surface definitions to write, .json or .xml; each mesh is written beside it, for surfaces.json as surfaces_scan.ply")
      ->required();
  app.add_option("--save-points", flags.points,
                 "Also write the points with normals and standard deviations, .ply or .pcd");
  app.add_option(
      "--save-depth", flags.depth,
      "Also write the camera's depths in metres, .pfm (0: not measured): detect-surfaces --sensor-model scan finds walls, columns and balls in them. "
      "Of several scans depth.pfm becomes depth_scan_CAMERA_PROJECTOR.pfm");
  app.add_option(
      "--preview", flags.preview,
      "Also draw the surface and its standard deviation, .png; several are named as those of --save-depth");
  add_parsed(
      app, "--viewer", [&](const std::string& text) { flags.eye = io::parse_position(text); },
      "Position of an eye in the rig, as render-to-image --viewer has it: report how far content is off there by the rig's "
      "covariance");
  app.add_option(
      "--truth", flags.truth,
      "True depths of a simulation, truth_depth.pfm or the view's folder of simulate-captures (of several cameras): "
      "report the distance to them. Of several stations the folder of each, in their order");
  declare_stations(app, flags.stations);
}

void require_writable(const Flags& flags) {
  if (!flags.depth.empty() && fs::path(flags.depth).extension() != ".pfm")
    throw Error(ErrorKind::kInput, "--save-depth " + flags.depth, "depths are written as .pfm alone",
                "name it e.g. depth.pfm");
  for (const std::string& path :
       {flags.output, flags.points, flags.depth, flags.preview, flags.stations.save_poses})
    if (!path.empty()) io::require_writable(path);
}

/// Of the view that `camera` captured: the file itself, or the one of this camera in the folder.
fs::path truth_of(const Flags& flags, const session::SessionPlan& plan, const std::string& camera) {
  const bool has_one_camera = plan.cameras.size() == 1;
  const std::string& truth = flags.truth.front();
  if (fs::is_directory(truth))
    return fs::path(truth) / (has_one_camera ? "truth_depth.pfm" : "truth_depth_" + camera + ".pfm");
  if (has_one_camera) return truth;
  throw Error(ErrorKind::kInput, "--truth " + truth, "the session has several cameras",
              "give the view's folder, with truth_depth_CAMERA.pfm of each");
}

std::optional<scan::ScanError> true_error(const fs::path& file, const scan::Scan& scan) {
  const DepthPixels truth = io::load_depth_pixels(file);
  const ImageF* metres = std::get_if<ImageF>(&truth);
  if (metres == nullptr || metres->size() != scan.depth.size())
    throw Error(ErrorKind::kInput, file.string(), "it has no float depths of the camera's size",
                "give the truth_depth.pfm of this view");
  return scan::compare(scan, *metres);
}

/// The scans of one folder.
std::vector<report::ScannedSurface> scans_of(const Flags& flags, const std::string& captures, const Rig& rig,
                                             Diagnostics& remarks, Console& console) {
  const session::SessionPlan plan = session::open(captures, flags.open);
  const bool is_alone = flags.captures.size() == 1;
  std::vector<report::ScannedSurface> surfaces;
  const std::vector<session::CapturedLight> lights = session::read_light(plan, flags.view);
  for (const session::CapturedLight& seen : lights) {
    console.progress("scans of " + captures, int(surfaces.size()), int(lights.size()));
    report::ScannedSurface surface;
    surface.name = scan_name(seen.camera, seen.projector, lights.size());
    surface.scan = scan::measure_depth(seen.light, rig, seen.camera, seen.projector, flags.scan);
    if (flags.eye) {
      surface.viewer = scan::viewer_error(surface.scan, *flags.eye);
      remarks.append(surface.viewer->diagnostics);
    }
    if (is_alone) surface.mesh = scan::mesh_of(surface.scan, flags.stations.merge.mesh);
    if (is_alone && !flags.truth.empty())
      surface.error = true_error(truth_of(flags, plan, seen.camera), surface.scan);
    remarks.append(seen.light.diagnostics);
    remarks.append(surface.scan.diagnostics);
    surfaces.push_back(std::move(surface));
  }
  return surfaces;
}

void scan_one(const Flags& flags, const Rig& rig, Diagnostics& remarks, std::vector<std::string>& files,
              Console& console) {
  const std::vector<report::ScannedSurface> surfaces =
      scans_of(flags, flags.captures.front(), rig, remarks, console);
  std::vector<NamedMesh> meshes;
  for (const report::ScannedSurface& surface : surfaces) meshes.push_back({surface.name, &surface.mesh});
  save_scan_meshes(flags.output, meshes, "rig", files);
  save_scan_files({flags.points, flags.depth, flags.preview}, surfaces, files);
  console.say(report::lines(surfaces));
  console.summary().merge(report::to_json(surfaces));
}

void scan_stations(const Flags& flags, const Rig& rig, Diagnostics& remarks, std::vector<std::string>& files,
                   Console& console) {
  const std::vector<PoseWithCovariance> poses = known_poses(flags.stations, rig, flags.captures.size());
  std::vector<scan::Station> stations;
  std::vector<TrueStation> truth;
  for (std::size_t s = 0; s < flags.captures.size(); ++s) {
    scan::Station station;
    station.name = std::to_string(s + 1);
    for (report::ScannedSurface& surface : scans_of(flags, flags.captures[s], rig, remarks, console))
      station.scans.push_back(std::move(surface.scan));
    if (!poses.empty()) station.world_from_rig = poses[s];
    stations.push_back(std::move(station));
    if (s < flags.truth.size()) truth.push_back(load_true_station(flags.truth[s], flags.view));
  }
  const report::StationsReport merged =
      console.reporting(remarks, [&] { return merged_stations(flags.stations, stations, std::move(truth)); });
  save_scan_meshes(flags.output, {{"scan", &merged.merged.mesh}}, poses.empty() ? "rig" : "world", files);
  for (const std::string& file : save_station_files(flags.stations, flags.points, flags.preview, merged))
    files.push_back(file);
  console.say(report::lines(merged));
  console.summary().merge(report::to_json(merged));
  remarks.append(merged.registration.diagnostics);
  remarks.append(merged.merged.diagnostics);
}

ExitCode scan_surfaces(const Flags& flags, Console& console) {
  const Rig rig = io::load_rig(flags.rig);
  require_writable(flags);
  require_stations(flags.stations, flags.captures.size(), flags.truth.size(), !flags.depth.empty());
  std::vector<std::string> files;
  Diagnostics remarks;
  (flags.captures.size() == 1 ? scan_one : scan_stations)(flags, rig, remarks, files, console);
  console.summary().set("/files", files);
  console.report(remarks);
  for (const std::string& file : files) console.say("wrote " + file);
  return exit_code(remarks);
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  Flags flags;
  return run_tool(
      argc, argv,
      {"scan-surfaces",
       "Measures the shape of a room from captures of Gray code or phase shift and a calibrated rig: points with standard "
       "deviations, and a mesh that content can be put on."},
      [&](CLI::App& app) { declare(app, flags); },
      [&](Console& console) { return scan_surfaces(flags, console); });
}
