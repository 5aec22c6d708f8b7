/// scan-surfaces: captures of Gray code or phase shift + a rig -> points, a mesh, and surfaces.json.
#include <CLI/CLI.hpp>

#include "common/cli.hpp"
#include "common/light_flags.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/depth_file.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/image/pfm.hpp"
#include "procam/io/mesh/mesh_writer.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/io/text.hpp"
#include "procam/report/scan.hpp"
#include "procam/scan/scan_mesh.hpp"
#include "procam/session/light.hpp"

namespace procam::tools {
namespace {

namespace fs = std::filesystem;

struct Flags {
  std::string captures, view, rig, output, points, depth, preview, truth;
  session::OpenOptions open;
  scan::ScanOptions scan;
  scan::MeshOptions mesh;
};

void declare(CLI::App& app, Flags& flags) {
  app.add_option(
         "--captures", flags.captures,
         "Folder with a sub-folder of numbered frames, as capture-session and simulate-captures write it; no board "
         "is needed")
      ->required();
  app.add_option("--rig", flags.rig, "rig.json of the camera and projector, as calibrate-projector writes it")
      ->required();
  app.add_option("--view", flags.view, "Name of the sub-folder, where there are several");
  declare_light(app, flags.open);
  add_parsed(
      app, "--deviation", [&](const std::string& text) { flags.mesh.max_deviation = io::parse_length(text); },
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
  app.add_option(
      "--truth", flags.truth,
      "True depths of a simulation, truth_depth.pfm or the view's folder of simulate-captures (of several cameras): "
      "report the distance to them");
}

void require_writable(const Flags& flags) {
  if (!flags.depth.empty() && fs::path(flags.depth).extension() != ".pfm")
    throw Error(ErrorKind::kInput, "--save-depth " + flags.depth, "depths are written as .pfm alone",
                "name it e.g. depth.pfm");
  for (const std::string& path : {flags.output, flags.points, flags.depth, flags.preview})
    if (!path.empty()) io::require_writable(path);
}

/// Of the view that `camera` captured: the file itself, or the one of this camera in the folder.
fs::path truth_of(const Flags& flags, const session::SessionPlan& plan, const std::string& camera) {
  const bool has_one_camera = plan.cameras.size() == 1;
  if (fs::is_directory(flags.truth))
    return fs::path(flags.truth) / (has_one_camera ? "truth_depth.pfm" : "truth_depth_" + camera + ".pfm");
  if (has_one_camera) return flags.truth;
  throw Error(ErrorKind::kInput, "--truth " + flags.truth, "the session has several cameras",
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

/// "scan", or with several cameras or projectors "scan_CAMERA_PROJECTOR".
std::string name_of(const session::CapturedLight& seen, std::size_t count) {
  std::string name = "scan";
  if (count > 1)
    for (const std::string& device : {seen.camera, seen.projector})
      name += device.empty() ? "" : "_" + device;
  return name;
}

/// FILE.EXT, of several scans FILE_SCAN.EXT.
std::string file_of(const std::string& path, const std::string& scan, std::size_t count) {
  if (count == 1) return path;
  const fs::path file(path);
  return (file.parent_path() / (file.stem().string() + "_" + scan + file.extension().string())).string();
}

SurfaceSet save_meshes(const Flags& flags, const std::vector<report::ScannedSurface>& surfaces,
                       std::vector<std::string>& files) {
  SurfaceSet set;
  for (const report::ScannedSurface& surface : surfaces) {
    MeshSurface geometry;
    geometry.frame = "rig";
    geometry.file = fs::path(flags.output).stem().string() + "_" + surface.name + ".ply";
    geometry.mesh = std::make_shared<const Mesh>(surface.mesh);
    const fs::path path = fs::path(flags.output).parent_path() / geometry.file;
    io::save_mesh(path, surface.mesh);
    files.push_back(path.string());
    Surface definition;
    definition.name = surface.name;
    definition.geometry = geometry;
    set.surfaces.push_back(definition);
  }
  io::save_surfaces(flags.output, set);
  files.push_back(flags.output);
  return set;
}

void append(const PointCloud& more, PointCloud& all) {
  all.points.insert(all.points.end(), more.points.begin(), more.points.end());
  all.normals.insert(all.normals.end(), more.normals.begin(), more.normals.end());
  all.sigma.insert(all.sigma.end(), more.sigma.begin(), more.sigma.end());
}

void save_others(const Flags& flags, const std::vector<report::ScannedSurface>& surfaces,
                 std::vector<std::string>& files) {
  if (!flags.points.empty()) {
    PointCloud all;
    for (const report::ScannedSurface& surface : surfaces) append(scan::point_cloud(surface.scan), all);
    io::save_points(flags.points, all);
    files.push_back(flags.points);
  }
  for (const report::ScannedSurface& surface : surfaces) {
    if (!flags.depth.empty()) {
      files.push_back(file_of(flags.depth, surface.name, surfaces.size()));
      io::save_pfm(files.back(), surface.scan.depth);
    }
    if (!flags.preview.empty()) {
      files.push_back(file_of(flags.preview, surface.name, surfaces.size()));
      io::save_image(files.back(), report::scan_picture(surface.scan));
    }
  }
}

ExitCode scan_surfaces(const Flags& flags, Console& console) {
  const Rig rig = io::load_rig(flags.rig);
  const session::SessionPlan plan = session::open(flags.captures, flags.open);
  require_writable(flags);
  std::vector<report::ScannedSurface> surfaces;
  Diagnostics remarks;
  const std::vector<session::CapturedLight> lights = session::read_light(plan, flags.view);
  for (const session::CapturedLight& seen : lights) {
    console.progress("scans", int(surfaces.size()), int(lights.size()));
    report::ScannedSurface surface;
    surface.name = name_of(seen, lights.size());
    surface.scan = scan::measure_depth(seen.light, rig, seen.camera, seen.projector, flags.scan);
    surface.mesh = scan::mesh_of(surface.scan, flags.mesh);
    if (!flags.truth.empty()) surface.error = true_error(truth_of(flags, plan, seen.camera), surface.scan);
    remarks.append(seen.light.diagnostics);
    remarks.append(surface.scan.diagnostics);
    surfaces.push_back(std::move(surface));
  }
  std::vector<std::string> files;
  save_meshes(flags, surfaces, files);
  save_others(flags, surfaces, files);
  console.say(report::lines(surfaces));
  console.summary().merge(report::to_json(surfaces));
  console.summary().set("/files", files);
  console.report(remarks);
  for (const std::string& file : files) console.say("wrote " + file);
  return ExitCode::kOk;
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
