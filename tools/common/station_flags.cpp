#include "common/station_flags.hpp"

#include <CLI/CLI.hpp>
#include <filesystem>

#include "procam/io/files.hpp"
#include "procam/io/image/depth_file.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/mesh/mesh_writer.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"

namespace procam::tools {
namespace {

namespace fs = std::filesystem;

/// The rig's pose by that of one of its devices.
std::optional<Pose> rig_from_frame(const Rig& rig, const std::string& frame) {
  if (frame == "rig") return Pose();
  for (const RigCamera& camera : rig.cameras)
    if (camera.name == frame) return camera.rig_from_camera;
  for (const RigProjector& projector : rig.projectors)
    if (projector.name == frame) return projector.rig_from_projector;
  return std::nullopt;
}

/// world_from_rig of a pose file, in either direction, of the rig or of a device of it; and the world's name.
PoseWithCovariance pose_of_rig(const std::string& file, const Rig& rig, std::string& world) {
  const FrameTree::Link link = io::load_pose(file);
  const auto of_source = rig_from_frame(rig, link.source), of_target = rig_from_frame(rig, link.target);
  if (of_source.has_value() == of_target.has_value())
    throw Error(ErrorKind::kInput, file,
                "it is the pose of '" + link.source + "' in '" + link.target +
                    "', and one of them must be the rig or a device of it",
                "give the pose that locate-projector wrote, or one with target \"world\" and source \"rig\"");
  const std::string& name = of_source ? link.target : link.source;
  if (!world.empty() && name != world)
    throw Error(ErrorKind::kInput, file,
                "its world is '" + name + "', that of the first station '" + world + "'",
                "give poses in one world");
  world = name;
  const PoseWithCovariance world_from_device =
      of_source ? link.target_from_source : inverse(link.target_from_source);
  const Pose device_from_rig = (of_source ? *of_source : *of_target).inverse();
  return compose(world_from_device, PoseWithCovariance{device_from_rig, Mat6::Zero()});
}

}  // namespace

void declare_stations(CLI::App& app, StationFlags& flags) {
  CLI::Option* poses = app.add_option(
      "--station-pose", flags.poses,
      "Of several --captures: pose.json of the rig, or of a device of it, in the world, one for each in their order, "
      "as locate-projector writes it. Without it the stations are registered by the surfaces that they see in common");
  poses->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  add_parsed(
      app, "--pose-sigma",
      [&](const std::string& text) {
        flags.pose_sigma = io::parse_length_and_angle(text);
        if (!(flags.pose_sigma.length > 0 && flags.pose_sigma.angle > 0))
          throw Error(ErrorKind::kInput, "'" + text + "'", "both sigmas must be positive",
                      "give e.g. 10mm,0.5deg");
      },
      "Standard deviations of --station-pose files without a covariance, e.g. 10mm,0.5deg");
  app.add_flag("--keep-poses", flags.keep_poses,
               "Keep --station-pose as it is: the common surfaces are only compared")
      ->needs(poses);
  add_parsed(
      app, "--max-move",
      [&](const std::string& text) { flags.registration.max_move = io::parse_length(text); },
      "Without --station-pose: how far apart two stations may be (default 1m)");
  add_parsed(
      app, "--max-turn",
      [&](const std::string& text) { flags.registration.max_turn = io::parse_angle(text); },
      "Without --station-pose: how far the rig may turn between two stations (default 60deg)");
  app.add_option(
      "--save-poses", flags.save_poses,
      "Of several --captures: also write the pose of each station, for poses.json as poses_1.json, poses_2.json ...");
}

std::vector<PoseWithCovariance> known_poses(const StationFlags& flags, const Rig& rig, std::size_t stations) {
  if (flags.poses.empty()) return {};
  if (flags.poses.size() != stations)
    throw Error(ErrorKind::kInput, "--station-pose",
                format("%zu files are given for %zu stations", flags.poses.size(), stations),
                "give one for each --captures, in their order");
  std::vector<PoseWithCovariance> poses;
  std::string world;
  for (const std::string& file : flags.poses) {
    PoseWithCovariance pose = pose_of_rig(file, rig, world);
    if (pose.covariance.isZero()) {
      if (!(flags.pose_sigma.length > 0))
        throw Error(ErrorKind::kInput, file, "it has no covariance",
                    "give --pose-sigma, e.g. 10mm,0.5deg, the standard deviations of position and rotation");
      Vec6 variance;
      variance << Vec3::Constant(flags.pose_sigma.angle * flags.pose_sigma.angle),
          Vec3::Constant(flags.pose_sigma.length * flags.pose_sigma.length);
      const Mat6 to_world = adjoint(pose.pose);
      pose.covariance = to_world * variance.asDiagonal() * to_world.transpose();
    }
    poses.push_back(pose);
  }
  return poses;
}

TrueStation load_true_station(const std::string& folder, const std::string& view) {
  const fs::path root(folder);
  TrueStation out;
  out.world_from_rig = io::load_pose(root / "truth_station.json").target_from_source.pose;
  const Rig rig = io::load_rig(root / "truth.json");
  for (const RigCamera& camera : rig.cameras) {
    const std::string file =
        rig.cameras.size() == 1 ? "truth_depth.pfm" : "truth_depth_" + camera.name + ".pfm";
    const fs::path path = root / (view.empty() ? "view_00" : view) / file;
    const DepthPixels depth = io::load_depth_pixels(path);
    const ImageF* metres = std::get_if<ImageF>(&depth);
    if (metres == nullptr || metres->size() != camera.camera.size)
      throw Error(ErrorKind::kInput, path.string(), "it has no float depths of the camera's size",
                  "give the folder of simulate-captures --room");
    out.views.push_back({camera.camera, out.world_from_rig * camera.rig_from_camera, *metres});
  }
  return out;
}

report::StationsReport merged_stations(const StationFlags& flags, const std::vector<scan::Station>& stations,
                                       std::vector<TrueStation> truth) {
  report::StationsReport out;
  scan::RegistrationOptions options = flags.registration;
  options.refine = !flags.keep_poses;
  out.registration = scan::register_stations(stations, options);
  out.merged = scan::merge_stations(stations, out.registration, flags.merge);
  if (truth.empty()) return out;
  // Without known poses the world is the first station's rig.
  const Pose to_world = out.registration.has_known_poses ? Pose() : truth.front().world_from_rig.inverse();
  std::vector<scan::TrueView> views;
  for (std::size_t s = 0; s < truth.size(); ++s) {
    out.true_pose_errors.push_back(
        report::pose_error(out.registration.stations[s].pose, to_world * truth[s].world_from_rig));
    for (scan::TrueView& view : truth[s].views) {
      view.world_from_camera = to_world * view.world_from_camera;
      views.push_back(std::move(view));
    }
  }
  for (std::size_t s = 0; s < truth.size(); ++s) {
    PointCloud alone;
    for (const scan::Scan& scan : stations[s].scans) {
      const PointCloud more = scan::point_cloud(scan);
      for (const Vec3& point : more.points)
        alone.points.push_back(to_world * truth[s].world_from_rig * point);
      alone.sigma.insert(alone.sigma.end(), more.sigma.begin(), more.sigma.end());
    }
    out.true_pose_errors[s].single_rms = scan::compare(alone, views).rms;
  }
  out.true_error = scan::compare(out.merged.cloud, views);
  return out;
}

void require_stations(const StationFlags& flags, std::size_t stations, std::size_t truth, bool has_depth) {
  if (stations == 1) {
    if (!flags.poses.empty() || !flags.save_poses.empty())
      throw Error(ErrorKind::kInput, flags.poses.empty() ? "--save-poses" : "--station-pose",
                  "one station has no pose to other stations",
                  "give --captures several times, once a station");
    return;
  }
  if (has_depth)
    throw Error(ErrorKind::kInput, "--save-depth", "several stations have no common camera",
                "scan one station, or write --save-points");
  if (truth != 0 && truth != stations)
    throw Error(ErrorKind::kInput, "--truth",
                format("%zu folders are given for %zu stations", truth, stations),
                "give the folder of each station, in their order");
}

std::vector<std::string> save_station_files(const StationFlags& flags, const std::string& points,
                                            const std::string& preview,
                                            const report::StationsReport& report) {
  std::vector<std::string> files;
  if (!points.empty()) {
    io::save_points(points, report.merged.cloud);
    files.push_back(points);
  }
  if (!preview.empty()) {
    io::save_image(preview, report::stations_picture(report.merged));
    files.push_back(preview);
  }
  if (flags.save_poses.empty()) return files;
  const fs::path path(flags.save_poses);
  const scan::Registration& registration = report.registration;
  const std::string world =
      registration.has_known_poses ? "world" : "rig_of_station_" + registration.stations.front().name;
  for (const scan::RegisteredStation& station : registration.stations) {
    files.push_back(
        (path.parent_path() / (path.stem().string() + "_" + station.name + path.extension().string()))
            .string());
    io::save_pose(files.back(), {world, "rig", station.pose});
  }
  return files;
}

}  // namespace procam::tools
