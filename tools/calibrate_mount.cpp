/// calibrate-mount: poses of a robot or an arm, or angles of a pan-tilt head, + sightings of markers or planes -> mount.json,
/// the rig on what carries it, with covariance.
#include <CLI/CLI.hpp>

#include "common/cli.hpp"
#include "common/mount_flags.hpp"
#include "procam/io/exchange/calibration_file.hpp"
#include "procam/io/files.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/report/mount.hpp"

namespace procam::tools {
namespace {

std::string target_of(const MountFlags& flags) {
  switch (flags.options.carrier) {
    case calibrate::MountCarrier::kFlange:
      return "flange";
    case calibrate::MountCarrier::kHead:
      return "tilt";
    default:
      return "base";
  }
}

/// base_from_rig of a pose file, in either direction.
PoseWithCovariance load_prior(const MountFlags& flags) {
  const FrameTree::Link link = io::load_mount(flags.prior).pose;
  const std::string target = target_of(flags);
  const bool forward = link.target == target && link.source == "rig";
  if (!forward && !(link.target == "rig" && link.source == target))
    throw Error(ErrorKind::kInput, flags.prior,
                "it joins '" + link.target + "' to '" + link.source + "', not '" + target + "' to 'rig'",
                "give a mount: target " + target + ", source rig");
  PoseWithCovariance prior = forward ? link.target_from_source : inverse(link.target_from_source);
  if (flags.prior_sigma.length > 0) {  // about the rig's own origin
    Mat6 own = Mat6::Zero();
    own.diagonal() << Vec3::Constant(std::pow(flags.prior_sigma.angle, 2)),
        Vec3::Constant(std::pow(flags.prior_sigma.length, 2));
    const Mat6 to_left = adjoint(prior.pose);
    prior.covariance = to_left * own * to_left.transpose();
  }
  if (prior.covariance.isZero(0))
    throw Error(ErrorKind::kInput, flags.prior, "it has no covariance",
                "state how well it is known: --prior-sigma 20mm,2deg");
  return prior;
}

std::vector<calibrate::MountMarker> load_markers(const std::string& file) {
  std::vector<calibrate::MountMarker> markers;
  const MarkerMap map = io::load_marker_map(file);
  Mat6 own = Mat6::Zero();
  own.diagonal() << Vec3::Constant(std::pow(map.angle_sigma, 2)),
      Vec3::Constant(std::pow(map.position_sigma, 2));
  for (const PlacedMarker& marker : map.markers) {
    const Mat6 to_left = adjoint(marker.world_from_marker);
    markers.push_back({"marker_" + std::to_string(marker.id),
                       {marker.world_from_marker, to_left * own * to_left.transpose()}});
  }
  return markers;
}

/// The joint covariance only where there is more than the pose.
io::Mount mount_of(const calibrate::MountResult& result, const std::string& target) {
  io::Mount mount{{target, "rig", result.base_from_rig}, result.axes, {}, {}};
  if (result.world_from_base) mount.world_from_base = result.world_from_base->pose;
  if (mount.axes || mount.world_from_base) mount.joint_covariance = result.joint_covariance;
  return mount;
}

RigCamera depth_camera(const MountFlags& flags) {
  if (flags.intrinsics.empty()) return io::load_rig(flags.rig).camera(flags.depth_camera);
  RigCamera camera;
  camera.camera = io::load_camera(flags.intrinsics, "", session::depth_image_size(flags.depth)).camera;
  return camera;
}

void add_images(MountFlags& flags, session::MountRecording& drive, Console& console) {
  const auto add = [&](const std::vector<MarkerSighting>& seen) {
    drive.data.sightings.insert(drive.data.sightings.end(), seen.begin(), seen.end());
  };
  if (!flags.folder.empty()) {
    flags.images.folder = flags.folder;
    add(session::sightings_in_images(flags.images, io::load_rig(flags.rig).camera(flags.camera)));
  }
  const auto add_planes = [&](const session::PlaneSightings& planes, const char* kind) {
    add(planes.sightings);
    drive.diagnostics.append(planes.diagnostics);
    console.say(format("%zu %s, %zu planes in them", planes.images, kind, planes.sightings.size()));
  };
  const auto progress = [&](const std::string& file, int done, int total) {
    console.progress(file, done, total);
  };
  if (!flags.light_folder.empty()) {
    flags.light.folder = flags.light_folder;
    const Rig rig = io::load_rig(flags.rig);
    add_planes(session::planes_in_light(flags.light, rig.camera(flags.camera), rig.projector(flags.projector),
                                        progress),
               "images of the light");
  }
  if (!flags.depth_folder.empty()) {
    flags.depth.folder = flags.depth_folder;
    add_planes(session::planes_in_depth(flags.depth, depth_camera(flags), progress), "depth images");
  }
}

ExitCode calibrate_mount(MountFlags flags, Console& console) {
  for (const std::string& file : {flags.output, flags.picture})
    if (!file.empty()) io::require_writable(file);
  session::MountRecording drive = session::read_mount_data(flags.files);
  add_images(flags, drive, console);
  if (!flags.prior.empty()) flags.options.prior = load_prior(flags);
  if (!flags.markers.empty()) flags.options.markers = load_markers(flags.markers);

  const calibrate::MountResult result = calibrate::calibrate_mount(drive.data, flags.options);
  io::save_mount(flags.output, mount_of(result, target_of(flags)));
  if (!flags.picture.empty())
    io::write_file_atomically(flags.picture, report::mount_picture(result, drive.data));

  console.say(report::lines(result));
  console.summary().merge(report::to_json(result));
  Diagnostics diagnostics = drive.diagnostics;
  diagnostics.append(result.diagnostics);
  console.report(diagnostics);
  for (const std::string& file : {flags.output, flags.picture})
    if (!file.empty()) console.say("wrote " + file);
  return exit_code(diagnostics);
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  MountFlags flags;
  return run_tool(
      argc, argv,
      {"calibrate-mount",
       "Computes the pose of the rig on its robot base, on an arm or on a pan-tilt head from a motion past markers, "
       "of a robot also past walls: the carrier's poses or angles and what the rig sees. What the motion cannot observe has to be measured, and is "
       "named."},
      [&](CLI::App& app) {
        declare_inputs(app, flags);
        declare_images(app, flags);
        declare_stated(app, flags);
        app.add_option(
               "-o,--output", flags.output,
               "mount.json to write, for project-live --mount: target base, flange or tilt, source rig")
            ->required();
        app.add_option("--preview", flags.picture, "Also draw the drive and the mount from above, .svg");
        app.callback([&flags] {
          if (flags.files.base.empty() && flags.files.angles.empty())
            throw CLI::RequiredError("--base, --arm or --pan-tilt");
          if (flags.files.sightings.empty() && flags.folder.empty() && flags.depth_folder.empty() &&
              flags.light_folder.empty())
            throw CLI::RequiredError("--sightings, --images, --light or --depth");
          if (!flags.depth_folder.empty() && flags.rig.empty() && flags.intrinsics.empty())
            throw CLI::RequiredError("--rig or --intrinsics, with --depth");
        });
      },
      [&](Console& console) { return calibrate_mount(flags, console); });
}
