/// locate-projector: an image of markers + rig.json -> pose.json, projector_from_world with its covariance.
#include <CLI/CLI.hpp>
#include <cmath>

#include "common/cli.hpp"
#include "common/pose_lines.hpp"
#include "common/raster.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/track/locate.hpp"

namespace procam::tools {
namespace {

struct Flags {
  std::string rig, image, markers, camera, projector, output, annotate;
  std::optional<MarkerMap> marker;
};

void declare(CLI::App& app, Flags& flags) {
  app.add_option("--rig", flags.rig, "rig.json of calibrate-projector")->required();
  app.add_option("--image", flags.image, "Image of the markers by the camera of the rig, .png or .jpg")
      ->required();
  auto* marker = add_parsed(
      app, "--marker", [&](const std::string& text) { flags.marker = io::parse_marker(text); },
      "One marker that defines the world frame: DICTIONARY:ID:SIZE, the side of the black square, "
      "e.g. apriltag_36h11:3:160mm");
  auto* markers = app.add_option("--markers", flags.markers,
                                 "markers.json: several markers with their poses in the world");
  marker->excludes(markers);
  app.add_option("--camera-name", flags.camera, "Name of the device, for a rig with several");
  app.add_option("--projector", flags.projector, "Name of the device, for a rig with several");
  app.add_option("-o,--output", flags.output, "pose.json to write, for solve-surfaces --pose")->required();
  app.add_option("--preview", flags.annotate,
                 "Also write the image with the detected markers (green), the markers as the pose predicts "
                 "them (red) and the axes of the world (x red, y green, z blue), .png");
  app.callback([marker, markers] {
    if (marker->count() + markers->count() == 0) throw CLI::RequiredError("--marker or --markers");
  });
}

void say_markers(Console& console, const track::LocateResult& seen) {
  for (std::size_t i = 0; i < seen.markers.size(); ++i) {
    const track::LocatedMarker& marker = seen.markers[i];
    console.say(format("marker %-5d corners %.3f px from the fit, ", marker.id, marker.error_px) +
                (marker.used ? format("edges %.3f px RMS", marker.edge_rms_px) : "REJECTED"));
    const std::string at = "/markers/" + std::to_string(i);
    console.summary().set(at + "/id", marker.id);
    console.summary().set(at + "/used", marker.used);
    console.summary().set(at + "/corner_error_px", marker.error_px);
    console.summary().set(at + "/edge_rms_px", marker.edge_rms_px);
  }
}

ImageU8 annotate(const ImageU8& grey, const MarkerDetections& detections, const MarkerMap& map,
                 const Camera& camera, const Pose& camera_from_world) {
  ImageU8 picture = to_colour(grey);
  const Colour kGreen{40, 220, 60}, kRed{255, 60, 40}, kBlue{80, 120, 255};
  for (const SeenMarker& marker : detections.markers) {
    for (std::size_t i = 0; i < 4; ++i)
      draw_line(picture, marker.corners[i], marker.corners[(i + 1) % 4], kGreen);
    draw_number(picture, marker.corners[0] + Vec2(6, -14), marker.id, kGreen);
  }
  const auto draw = [&](const Vec3& a, const Vec3& b, const Colour& colour) {
    constexpr int kPieces = 16;  // the lens bends it
    for (int i = 0; i < kPieces; ++i) {
      const auto p = camera.project(camera_from_world * Vec3(a + (b - a) * i / kPieces)),
                 q = camera.project(camera_from_world * Vec3(a + (b - a) * (i + 1) / kPieces));
      if (p && q) draw_line(picture, *p, *q, colour);
    }
  };
  for (const PlacedMarker& placed : map.markers)
    for (std::size_t i = 0; i < 4; ++i) {
      const Vec2 a = marker_corners()[i] * placed.size, b = marker_corners()[(i + 1) % 4] * placed.size;
      draw(placed.world_from_marker * Vec3(a.x(), a.y(), 0), placed.world_from_marker * Vec3(b.x(), b.y(), 0),
           kRed);
    }
  const double length = map.markers.front().size;
  draw(Vec3::Zero(), Vec3(length, 0, 0), kRed);
  draw(Vec3::Zero(), Vec3(0, length, 0), kGreen);
  draw(Vec3::Zero(), Vec3(0, 0, length), kBlue);
  return picture;
}

ExitCode locate(const Flags& flags, Console& console) {
  for (const std::string& file : {flags.output, flags.annotate})
    if (!file.empty()) io::require_writable(file);
  const Rig rig = io::load_rig(flags.rig);
  const RigCamera& camera = rig.camera(flags.camera);
  const RigProjector& projector = rig.projector(flags.projector);
  const MarkerMap map = flags.marker ? *flags.marker : io::load_marker_map(flags.markers);
  const io::LoadedImage loaded = io::load_image(flags.image);
  const ImageU8 grey = io::green_channel(loaded.image);
  if (grey.size() != camera.camera.size)
    throw Error(ErrorKind::kInput, flags.image,
                "it has " + std::to_string(grey.width()) + "x" + std::to_string(grey.height()) +
                    " pixels, the rig's camera " + std::to_string(camera.camera.size.width) + "x" +
                    std::to_string(camera.camera.size.height),
                "use an image of that camera in the mode in which it was calibrated, neither scaled nor cut");

  const MarkerCells codes = detect::marker_cells(map.dictionary);
  const MarkerDetections detections = detect::detect_marker_edges(grey, codes, {camera.camera});
  const track::LocateResult seen = track::locate(detections, camera.camera, map);
  const track::Chain chain = track::projector_chain(rig, projector, camera, seen);
  io::save_pose(flags.output, chain.total);
  if (!flags.annotate.empty())
    io::save_image(flags.annotate,
                   annotate(grey, detections, map, camera.camera, seen.camera_from_world).view());

  say_markers(console, seen);
  for (std::size_t i = 0; i < chain.links.size(); ++i)
    say_link(console, chain.links[i], "/chain/" + std::to_string(i));
  say_link(console, chain.total, "/pose");
  if (seen.other) console.say(format("second pose            probability %.2g %%", 100 * seen.other_odds));
  console.summary().set("/second_pose_odds", seen.other_odds);
  console.summary().set("/chi2_per_dof", seen.chi2_per_dof);
  Diagnostics diagnostics = loaded.diagnostics;
  diagnostics.append(detections.diagnostics);
  diagnostics.append(seen.diagnostics);
  if (rig.covariance.empty())
    diagnostics.warn("rig_taken_as_exact",
                     "the rig file has no covariance: the stated sigmas hold the image's and the map's share "
                     "alone; calibrate with calibrate-projector to have the rig's");
  console.report(diagnostics);
  console.say("wrote " + flags.output + (flags.annotate.empty() ? "" : ", " + flags.annotate));
  return exit_code(diagnostics);
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  Flags flags;
  return run_tool(
      argc, argv,
      {"locate-projector",
       "Computes the projector's pose in the room from an image of ArUco or AprilTag markers."},
      [&](CLI::App& app) { declare(app, flags); }, [&](Console& console) { return locate(flags, console); });
}
