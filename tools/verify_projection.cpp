/// verify-projection: rig, surfaces and captures of a projected board -> the error in millimetres, an
/// alarm when something has moved, and corrected.json.
#include <CLI/CLI.hpp>

#include "common/cli.hpp"
#include "common/stated_surface.hpp"
#include "procam/analyze/verify.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/io/files.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/io/text.hpp"
#include "procam/report/verify.hpp"
#include "procam/session/projected_board.hpp"

namespace procam::tools {
namespace {

namespace fs = std::filesystem;

struct Flags {
  std::string rig, surfaces, pose, markers, surface, pattern, captures, camera, projector, output, picture,
      data;
  analyze::VerifyOptions options;
  io::LengthAndAngle map_sigma;
};

/// What counts as a movement, and what is corrected then.
void declare_correction(CLI::App& app, Flags& flags) {
  app.add_option_function<std::string>(
         "--correct",
         [&flags](const std::string& what) {
           flags.options.correct =
               what == "projector" ? analyze::Correct::kProjector : analyze::Correct::kSurface;
         },
         "What to correct after an alarm: projector (its pose in the rig) | surface (its pose)")
      ->check(CLI::IsMember({"projector", "surface"}));
  add_parsed(
      app, "--sigma-bump",
      [&](const std::string& text) {
        const io::LengthAndAngle sigma = io::parse_length_and_angle(text);
        if (!(sigma.length > 0 && sigma.angle > 0))
          throw Error(ErrorKind::kInput, "sigma '" + text + "'", "a bump of zero corrects nothing",
                      "give how far things may have moved, e.g. 1deg,20mm");
        flags.options.bump_position_sigma = sigma.length;
        flags.options.bump_rotation_sigma = sigma.angle;
      },
      "Standard deviation of the movement by a bump (default 1deg,20mm)");
  add_parsed(
      app, "--map-sigma",
      [&](const std::string& text) { flags.map_sigma = io::parse_length_and_angle(text); },
      "Standard deviation of the pose of the surface, about its own origin, e.g. 5mm,0.2deg; added "
      "to the covariance of --pose");
  app.add_option("--false-alarms", flags.options.false_alarm_rate,
                 "Probability of an alarm if nothing has moved")
      ->check(within(1e-9, 0.5))
      ->capture_default_str();
}

void declare(CLI::App& app, Flags& flags) {
  app.add_option("--rig", flags.rig, "rig.json of calibrate-projector")->required();
  app.add_option("--surfaces", flags.surfaces, "Surface definitions, .json or .xml")->required();
  app.add_option("--surface", flags.surface,
                 "Name of the surface with the projected board; needed if there are several");
  auto* pose = app.add_option(
      "--pose", flags.pose,
      "pose.json between 'world' and 'projector', 'rig' or a camera of the rig, for a surface in "
      "the world");
  auto* markers = app.add_option(
      "--markers", flags.markers,
      "markers.json: printed markers of the world in the same captures. The camera then locates the "
      "surface, instead of --pose");
  pose->excludes(markers);
  app.add_option("--captures", flags.captures, "Folder with the captures of the pattern, in its order")
      ->required();
  app.add_option("--pattern", flags.pattern,
                 "The projected board: chessboard, charuco, markers or circles, with its layout as in "
                 "session.json (default: from session.json in that folder or in the folder above)");
  app.add_option("--camera-name", flags.camera, "Name of the device, for a rig with several");
  app.add_option("--projector", flags.projector, "Name of the device, for a rig with several");
  declare_correction(app, flags);
  app.add_option("-o,--output", flags.output,
                 "Corrected file: rig.json for --correct projector, surfaces.json for --correct surface");
  app.add_option("--preview", flags.picture, "Also draw the errors on the surface, .svg");
  app.add_option("--data", flags.data, "Also write a table of the marks into this folder: marks.csv");
  app.callback([&flags] {
    if (flags.output.empty() != (flags.options.correct == analyze::Correct::kNothing))
      throw CLI::ValidationError("--correct and -o", "go together: what to correct, and the file for it");
    if (!flags.markers.empty() && flags.options.correct == analyze::Correct::kSurface)
      throw CLI::ValidationError("--markers",
                                 "measures the surface in this very view: there is nothing to correct");
  });
}

/// The calibration's own provenance, and what was done to it here.
Provenance with_correction(Provenance provenance, const analyze::VerifyResult& result, const Flags& flags,
                           const session::ProjectedBoardCapture& captures) {
  std::string& note = provenance.options["corrected"];
  note += (note.empty() ? "" : "; ") +
          format("verify-projection %s, %s: ", PROCAM_VERSION, utc_now().c_str()) +
          report::description(result.projector_moved) +
          format(" of %.3f on '%s' (%s)", 1e3 * result.rms, result.surface.c_str(), captures.pattern.c_str());
  provenance.inputs.push_back({flags.rig, io::sha256_of_file(flags.rig)});
  provenance.inputs.insert(provenance.inputs.end(), captures.inputs.begin(), captures.inputs.end());
  return provenance;
}

/// Without an alarm as well: then nothing is corrected, and the file says what was stated before.
void write_corrected(const analyze::VerifyResult& result, const Flags& flags,
                     const session::ProjectedBoardCapture& captures, const Rig& rig, SurfaceSet surfaces,
                     const Pose& rig_from_frame) {
  if (flags.options.correct == analyze::Correct::kProjector) {
    Rig corrected = result.rig.value_or(rig);
    if (result.rig) corrected.provenance = with_correction(rig.provenance, result, flags, captures);
    io::save_rig(flags.output, corrected);
  } else {
    if (result.rig_from_surface)
      plane_of(pick_surface(surfaces, result.surface, flags.surfaces)).frame_from_surface =
          (rig_from_frame.inverse() * result.rig_from_surface->pose).normalized();
    io::save_surfaces(flags.output, surfaces);
  }
}

ExitCode verify_projection(Flags flags, Console& console) {
  for (const std::string& file : {flags.output, flags.picture})
    if (!file.empty()) io::require_writable(file);
  if (!flags.data.empty()) report::require_folder(flags.data);
  const Rig rig = io::load_rig(flags.rig);
  const RigCamera& camera = rig.camera(flags.camera);
  const RigProjector& projector = rig.projector(flags.projector);
  SurfaceSet surfaces = io::load_surfaces(flags.surfaces);
  Surface& surface = pick_surface(surfaces, flags.surface, flags.surfaces);
  const PlanarSurface& plane = plane_of(surface);
  const session::ProjectedBoardCapture captures = session::read_projected_board(
      flags.captures, flags.pattern, projector.projector.size(), camera.camera.size);
  const KnownWorld frame =
      frame_of(surface, {flags.pose, flags.markers}, rig, camera, projector, captures.light.flat_lit);
  const analyze::StatedSurface stated = state_surface(surface, plane, frame, flags.map_sigma);

  const analyze::VerifyResult result =
      analyze::verify(rig, camera, projector, stated, captures.light.points, flags.options);
  if (!flags.output.empty() && !result.alarm)
    console.say("nothing is corrected: " + flags.output + " is as it was");
  if (!flags.output.empty())
    write_corrected(result, flags, captures, rig, surfaces, frame.rig_from_world.pose);
  if (!flags.picture.empty())
    io::write_file_atomically(
        flags.picture,
        report::verify_picture(result, content_outline(surface, projector, frame.rig_from_world.pose)));

  if (!flags.data.empty()) report::save_files(flags.data, report::verify_tables(result));

  console.say(report::lines(result));
  console.summary().merge(report::to_json(result));
  Diagnostics diagnostics = captures.light.diagnostics;
  diagnostics.append(frame.diagnostics);
  diagnostics.append(result.diagnostics);
  console.report(diagnostics);
  for (const std::string& file : {flags.output, flags.picture, flags.data})
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
      {"verify-projection",
       "Measures with the rig's camera whether the projector's light agrees with the rig file: millimetres "
       "per mark, an alarm if something has moved (exit 5), and the correction of the projector's or the "
       "surface's pose."},
      [&](CLI::App& app) { declare(app, flags); },
      [&](Console& console) { return verify_projection(flags, console); });
}
