/// calibrate-mount: a localiser's poses + sightings of markers -> mount.json, base_from_rig with its covariance.
#include <CLI/CLI.hpp>

#include "common/cli.hpp"
#include "procam/calibrate/mount.hpp"
#include "procam/io/files.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/text.hpp"
#include "procam/report/mount.hpp"
#include "procam/session/mount_data.hpp"

namespace procam::tools {
namespace {

struct Flags {
  session::MountFiles files;
  session::SightingImages images;
  std::string folder, rig, camera, markers, prior, output, picture;
  io::LengthAndAngle prior_sigma;
  calibrate::MountOptions options;
};

void declare_inputs(CLI::App& app, Flags& flags) {
  app.add_option(
         "--base", flags.files.base,
         "Poses of the base by the localiser: a pose log, or a trajectory (TUM, EuRoC, rosbag CSV, KITTI)")
      ->required();
  auto* sightings =
      app.add_option("--sightings", flags.files.sightings,
                     "Pose log of marker sightings: frame 'marker_3', child 'rig', with covariance");
  auto* images = app.add_option("--images", flags.folder,
                                "Or images of the rig's camera, each called after its time in seconds or "
                                "nanoseconds; with --rig, --dictionary and --marker-size");
  sightings->excludes(images);
  auto* rig = app.add_option("--rig", flags.rig, "rig.json, for --images");
  images->needs(rig);
  app.add_option("--camera-name", flags.camera, "its name, for a rig with several");
  add_parsed(
      app, "--dictionary",
      [&flags](const std::string& text) {
        const auto dictionary = marker_dictionary_named(text);
        if (!dictionary)
          throw Error(ErrorKind::kInput, "'" + text + "'", "no dictionary is called so",
                      "give e.g. apriltag_36h11 or 4x4_50");
        flags.images.dictionary = *dictionary;
      },
      "Dictionary of the markers in --images (default apriltag_36h11)");
  auto* size = add_parsed(
      app, "--marker-size", [&flags](const std::string& text) { flags.images.size = io::parse_length(text); },
      "Side of their black squares, e.g. 160mm");
  images->needs(size);
  app.add_option("--child", flags.files.child, "Frame of the base in the log (default base)");
  app.add_option("--rig-frame", flags.files.rig, "Frame of the rig in the log (default rig)");
}

void declare_stated(CLI::App& app, Flags& flags) {
  add_parsed(
      app, "--height",
      [&flags](const std::string& text) {
        const std::size_t sign = text.find("+-");
        if (sign == text.npos)
          throw Error(ErrorKind::kInput, "'" + text + "'", "a measured height needs its standard deviation",
                      "give e.g. 0.85m+-5mm");
        flags.options.height = calibrate::MountHeight{io::parse_length(text.substr(0, sign)),
                                                      io::parse_length(text.substr(sign + 2))};
        if (!(flags.options.height->sigma > 0))
          throw Error(ErrorKind::kInput, "'" + text + "'", "no measurement is exact", "give e.g. 0.85m+-5mm");
      },
      "Measured height of the rig's origin (first camera's centre) above the base's origin, e.g. 0.85m+-5mm: a drive "
      "in a plane cannot observe it");
  auto* prior =
      app.add_option("--prior", flags.prior,
                     "An earlier mount (drawing, calibration): a pose file between base and rig, weighted by "
                     "its covariance or --prior-sigma");
  add_parsed(
      app, "--prior-sigma",
      [&flags](const std::string& text) {
        flags.prior_sigma = io::parse_length_and_angle(text);
        if (!(flags.prior_sigma.length > 0 && flags.prior_sigma.angle > 0))
          throw Error(ErrorKind::kInput, "'" + text + "'", "both sigmas must be positive",
                      "give e.g. 20mm,2deg");
      },
      "Standard deviations of --prior, instead of its covariance, e.g. 20mm,2deg")
      ->needs(prior);
  app.add_option("--markers", flags.markers,
                 "markers.json: markers whose poses in the localiser's world were measured");
  add_parsed(
      app, "--motion",
      [&flags](const std::string& text) { flags.options.motion = calibrate::parse_base_motion(text); },
      "auto (default) | planar: a robot on a floor | full: six degrees of freedom");
  add_parsed(
      app, "--time-offset",
      [&flags](const std::string& text) {
        const bool early = text.rfind('-', 0) == 0;
        flags.options.time_offset = (early ? -1 : 1) * io::parse_duration(text.substr(early ? 1 : 0));
      },
      "Time by which the localiser's stamps are late against the camera's, roughly; it is estimated within 1 s of this");
  app.add_flag("--same-clock{false}", flags.options.estimate_time_offset,
               "The time offset is exact and not estimated");
}

/// base_from_rig of a pose file, in either direction.
PoseWithCovariance load_prior(const Flags& flags) {
  const FrameTree::Link link = io::load_pose(flags.prior);
  const bool forward = link.target == "base" && link.source == "rig";
  if (!forward && !(link.target == "rig" && link.source == "base"))
    throw Error(ErrorKind::kInput, flags.prior,
                "it joins '" + link.target + "' to '" + link.source + "', not 'base' to 'rig'",
                "give a mount: target base, source rig");
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
                "say how well it is known: --prior-sigma 20mm,2deg");
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

ExitCode calibrate_mount(Flags flags, Console& console) {
  for (const std::string& file : {flags.output, flags.picture})
    if (!file.empty()) io::require_writable(file);
  session::MountRecording drive = session::read_mount_data(flags.files);
  if (!flags.folder.empty()) {
    flags.images.folder = flags.folder;
    drive.data.sightings =
        session::sightings_in_images(flags.images, io::load_rig(flags.rig).camera(flags.camera));
  }
  if (!flags.prior.empty()) flags.options.prior = load_prior(flags);
  if (!flags.markers.empty()) flags.options.markers = load_markers(flags.markers);

  const calibrate::MountResult result = calibrate::calibrate_mount(drive.data, flags.options);
  io::save_pose(flags.output, {"base", "rig", result.base_from_rig});
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
  Flags flags;
  return run_tool(
      argc, argv,
      {"calibrate-mount",
       "Computes the pose of the rig on its robot base from a drive past markers: the localiser's poses and what the "
       "rig sees. What a drive in a plane cannot observe has to be measured, and is named."},
      [&](CLI::App& app) {
        declare_inputs(app, flags);
        declare_stated(app, flags);
        app.add_option("-o,--output", flags.output,
                       "mount.json to write: target base, source rig, for project-live --mount")
            ->required();
        app.add_option("--preview", flags.picture, "Also draw the drive and the mount from above, .svg");
        app.callback([&flags] {
          if (flags.files.sightings.empty() == flags.folder.empty())
            throw CLI::RequiredError("--sightings or --images");
        });
      },
      [&](Console& console) { return calibrate_mount(flags, console); });
}
