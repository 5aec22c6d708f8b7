/// verify-projection: rig, surfaces and captures of a projected board -> the error in millimetres, an
/// alarm when something has moved, and corrected.json.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>

#include "common/cli.hpp"
#include "common/room_frames.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/session/patterns.hpp"

#include "procam/analyze/error_sources.hpp"
#include "procam/analyze/verify.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/io/files.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/io/text.hpp"
#include "procam/report/verify.hpp"
#include "procam/surface/solve.hpp"
#include "procam/track/locate.hpp"

namespace procam::tools {
namespace {

namespace fs = std::filesystem;
constexpr double kDegrees = 1 / kDegree;

struct Flags {
  std::string rig, surfaces, pose, markers, surface, pattern, captures, camera, projector, output, picture;
  analyze::VerifyOptions options;
  io::LengthAndAngle map_sigma;
};

void declare(CLI::App& app, Flags& flags) {
  app.add_option("--rig", flags.rig, "rig.json, as calibrate-projector writes it")->required();
  app.add_option("--surfaces", flags.surfaces, "surface definitions, .json or .xml")->required();
  app.add_option("--surface", flags.surface,
                 "the one that the light falls on; needed where there are several");
  auto* pose =
      app.add_option("--pose", flags.pose,
                     "pose.json that joins 'world' to 'projector', 'rig' or a camera of the rig, for a "
                     "surface placed in the world");
  auto* markers =
      app.add_option("--markers", flags.markers,
                     "markers.json: printed markers of the world that show in the same captures. The "
                     "camera then measures where the surface is, instead of --pose");
  pose->excludes(markers);
  app.add_option("--captures", flags.captures, "folder with the captures of the pattern, in its order")
      ->required();
  app.add_option(
      "--pattern", flags.pattern,
      "the projected board that was shown: chessboard, charuco, markers or circles, with its layout as "
      "in session.json (default: from session.json in that folder or the one above)");
  app.add_option("--camera", flags.camera, "its name, for a rig with several");
  app.add_option("--projector", flags.projector, "its name, for a rig with several");
  app.add_option_function<std::string>(
         "--correct",
         [&flags](const std::string& what) {
           flags.options.correct =
               what == "projector" ? analyze::Correct::kProjector : analyze::Correct::kSurface;
         },
         "what to correct when the alarm fires: projector (its place in the rig) | surface (its pose)")
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
      "how far a thing moves when it is bumped, one standard deviation (default 1deg,20mm)");
  add_parsed(
      app, "--map-sigma",
      [&](const std::string& text) { flags.map_sigma = io::parse_length_and_angle(text); },
      "how well the surface's pose is known, about its own origin, e.g. 5mm,0.2deg; adds to what --pose "
      "states");
  app.add_option("--false-alarms", flags.options.false_alarm_rate, "share of sound checks that give an alarm")
      ->check(CLI::Range(1e-9, 0.5))
      ->capture_default_str();
  app.add_option("-o,--output", flags.output,
                 "the corrected file: rig.json for --correct projector, surfaces.json for --correct surface");
  app.add_option("--picture", flags.picture, "also draw the errors on the surface, .svg");
  app.callback([&flags] {
    if (flags.output.empty() != (flags.options.correct == analyze::Correct::kNothing))
      throw CLI::ValidationError("--correct and -o", "go together: what to correct, and the file for it");
    if (!flags.markers.empty() && flags.options.correct == analyze::Correct::kSurface)
      throw CLI::ValidationError("--markers",
                                 "measures the surface in this very view: there is nothing to correct");
  });
}

struct Captures {
  session::ProjectedBoardPoints light;
  std::string pattern;
  std::vector<InputFile> inputs;
};

std::string pattern_of(const Flags& flags) {
  if (!flags.pattern.empty()) return flags.pattern;
  const fs::path folder = fs::path(flags.captures).lexically_normal();
  for (const fs::path& place :
       {folder, (folder.filename().empty() ? folder.parent_path() : folder).parent_path()})
    if (const auto session = io::load_session(place.empty() ? fs::path(".") : place))
      if (!session->pattern.empty()) return session->pattern;
  throw Error(ErrorKind::kInput, flags.captures, "no session.json there or above says what was shown",
              "give --pattern, e.g. --pattern charuco");
}

Captures read_captures(const Flags& flags, const RigProjector& projector, const RigCamera& camera) {
  Captures captures{{}, pattern_of(flags), {}};
  const auto pattern = session::make_pattern(captures.pattern, projector.projector.size());
  if (!pattern->on_blank_paper())
    throw Error(ErrorKind::kInput, "pattern '" + captures.pattern + "'", "it is not a projected board",
                "show one of chessboard, charuco, markers, circles (charuco: any part of it is enough)");
  const io::CaptureFolder folder =
      io::load_capture_folder(flags.captures, pattern->frame_count(), pattern->channels());
  const ImageSize size = folder.frames.front().size();
  if (size != camera.camera.size)
    throw Error(ErrorKind::kInput, flags.captures,
                "its pictures have " + io::format_size(size) + " pixels, the rig's camera " +
                    io::format_size(camera.camera.size),
                "use pictures of that camera in the mode in which it was calibrated, neither scaled nor cut");
  const auto light = pattern->read_light({folder.frames.begin(), folder.frames.end()});
  if (light->points.empty())
    throw Error(
        ErrorKind::kInput, flags.captures,
        "the pattern " + captures.pattern + " is not found in it" +
            (light->diagnostics.items.empty() ? "" : " (" + light->diagnostics.items.front().message + ")"),
        "give the --pattern that was shown, and let the camera see it sharp and bright");
  captures.light = *light;
  captures.light.diagnostics.append(folder.diagnostics);
  for (const fs::path& file : folder.files)
    captures.inputs.push_back({file.string(), io::sha256_of_file(file)});
  return captures;
}

/// The surface that the light falls on, in the file's set.
Surface& pick_surface(SurfaceSet& set, const Flags& flags) {
  std::string names;
  for (Surface& surface : set.surfaces) {
    if (surface.name == flags.surface || (flags.surface.empty() && set.surfaces.size() == 1)) return surface;
    names += (names.empty() ? "" : ", ") + surface.name;
  }
  throw Error(ErrorKind::kInput, flags.surfaces,
              flags.surface.empty() ? "it has " + std::to_string(set.surfaces.size()) + " surfaces"
                                    : "it has no surface '" + flags.surface + "'",
              "name with --surface the one that the light falls on" + (names.empty() ? "" : ": " + names));
}

PlanarSurface& plane_of(Surface& surface) {
  auto* plane = std::get_if<PlanarSurface>(&surface.geometry);
  const char* why = !plane ? "it is given in projector pixels and has no place in the room"
                    : plane->frame == "projector"
                        ? "it is placed in the projector's own frame and moves with it"
                        : nullptr;
  if (why)
    throw Error(ErrorKind::kInput, "surface '" + surface.name + "'", why,
                "use a surface with points in metres, placed in the world or the rig");
  return *plane;
}

/// Where the world is, with what states it.
struct KnownWorld {
  PoseWithCovariance rig_from_world;
  MatX jacobian_camera;  ///< see analyze::StatedSurface
  Diagnostics diagnostics;
};

/// Printed markers in the flat-lit picture.
KnownWorld world_by_markers(const std::string& file, const RigCamera& camera, const ImageU8& flat_lit) {
  const MarkerMap map = io::load_marker_map(file);
  const MarkerDetections detections =
      detect::detect_marker_edges(flat_lit, detect::marker_cells(map.dictionary), {camera.camera});
  const track::LocateResult seen = track::locate(detections, camera.camera, map);
  const Mat6 to_rig = adjoint(camera.rig_from_camera);
  KnownWorld world{
      {camera.rig_from_camera * seen.camera_from_world, to_rig * seen.covariance * to_rig.transpose()},
      MatX(6, seen.jacobian_lens.cols() + 6),
      detections.diagnostics};
  world.jacobian_camera << to_rig * seen.jacobian_lens, Mat6::Identity();
  world.diagnostics.append(seen.diagnostics);
  return world;
}

/// The pose of the frame that the surface is placed in.
KnownWorld frame_of(const PlanarSurface& plane, const Flags& flags, const Rig& rig, const RigCamera& camera,
                    const RigProjector& projector, const ImageU8& flat_lit) {
  if (plane.frame == "rig" && flags.markers.empty()) return {};
  if (plane.frame == "rig")
    throw Error(ErrorKind::kInput, "surface '" + flags.surface + "'",
                "it is placed in the rig, and --markers measure where the world is",
                "place it in the world of the markers, or leave --markers out");
  if (plane.frame != "world")
    throw Error(ErrorKind::kInput, "surface '" + flags.surface + "'",
                "its frame '" + plane.frame + "' is unknown", "place it in world or rig");
  if (!flags.markers.empty()) return world_by_markers(flags.markers, camera, flat_lit);
  if (flags.pose.empty())
    throw Error(
        ErrorKind::kInput, "surface '" + flags.surface + "'", "it is placed in the world",
        "say where that is: --pose pose.json, or --markers markers.json when some show in the captures");
  return {room_frames(rig, projector, io::load_pose(flags.pose)).get("rig", "world"), {}, {}};
}

analyze::StatedSurface state_surface(const Surface& surface, const PlanarSurface& plane,
                                     const KnownWorld& world, const io::LengthAndAngle& sigma) {
  analyze::StatedSurface stated{surface.name,
                                compose(world.rig_from_world, {plane.frame_from_surface, Mat6::Zero()}),
                                world.jacobian_camera};
  const Mat6 to_rig = adjoint(stated.rig_from_surface.pose);
  stated.rig_from_surface.covariance +=
      to_rig * analyze::isotropic_pose_covariance(sigma.length, sigma.angle) * to_rig.transpose();
  return stated;
}

/// Corners of the content on the surface, metres.
Points2 content_outline(const Surface& surface, const RigProjector& projector, const Pose& rig_from_world) {
  const SolvedSurfaceSet solved = surface::solve_surfaces(
      {{surface}}, projector, projector.rig_from_projector.inverse() * rig_from_world);
  const Mat3& map = std::get<PlacedPlane>(solved.surfaces.front().placement).plane_from_content;
  Points2 corners;
  for (const Vec2& uv : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)})
    corners.push_back(Vec3(map * Vec3(uv.x(), uv.y(), 1)).hnormalized());
  return corners;
}

std::string words_of(const analyze::Movement& m) {
  return format("%s turned by %.3f +- %.3f deg and shifted by %.2f +- %.2f mm: leaves %.3f mm rms",
                m.what.c_str(), m.angle() * kDegrees, m.angle_sigma() * kDegrees, 1e3 * m.shift(),
                1e3 * m.shift_sigma(), 1e3 * m.rms_after);
}

void summarize(const analyze::Movement& m, const std::string& at, Summary& summary) {
  const auto list = [](const Vec3& v) { return std::vector<double>{v.x(), v.y(), v.z()}; };
  const Vec6 sigma = m.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  summary.set(at + "/what", m.what);
  summary.set(at + "/angle_deg", m.angle() * kDegrees);
  summary.set(at + "/angle_sigma_deg", m.angle_sigma() * kDegrees);
  summary.set(at + "/shift_mm", 1e3 * m.shift());
  summary.set(at + "/shift_sigma_mm", 1e3 * m.shift_sigma());
  summary.set(at + "/rotation_deg", list(kDegrees * m.moved.head<3>()));
  summary.set(at + "/rotation_sigma_deg", list(kDegrees * sigma.head<3>()));
  summary.set(at + "/translation_mm", list(1e3 * m.moved.tail<3>()));
  summary.set(at + "/translation_sigma_mm", list(1e3 * sigma.tail<3>()));
  summary.set(at + "/rms_after_mm", 1e3 * m.rms_after);
}

void say_marks(Console& console, const analyze::VerifyResult& result) {
  console.say(format("%-6s %16s %18s %18s %15s %8s", "mark", "projector px", "on surface mm", "error mm",
                     "sigma mm", "chi2"));
  for (std::size_t i = 0; i < result.marks.size(); ++i) {
    const analyze::VerifiedMark& mark = result.marks[i];
    const Vec2 at = 1e3 * mark.intended, error = 1e3 * mark.error,
               sigma = 1e3 * mark.covariance.diagonal().cwiseSqrt();
    const Vec2& pixel = mark.seen.projector_pixel;
    console.say(format("%-6zu %7.1f %8.1f  %8.1f %8.1f  %8.3f %8.3f  %7.3f %7.3f %8.3g", i, pixel.x(),
                       pixel.y(), at.x(), at.y(), error.x(), error.y(), sigma.x(), sigma.y(), mark.chi2) +
                (!mark.rejection.empty() ? "  rejected: " + mark.rejection
                 : mark.beyond           ? "  beyond"
                                         : ""));
    const std::string to = "/marks/" + std::to_string(i);
    Summary& summary = console.summary();
    summary.set(to + "/projector_px", std::vector<double>{pixel.x(), pixel.y()});
    summary.set(to + "/camera_px",
                std::vector<double>{mark.seen.camera_pixel.x(), mark.seen.camera_pixel.y()});
    summary.set(to + "/on_surface_mm", std::vector<double>{at.x(), at.y()});
    summary.set(to + "/error_mm", std::vector<double>{error.x(), error.y()});
    summary.set(to + "/sigma_mm", std::vector<double>{sigma.x(), sigma.y()});
    summary.set(to + "/chi2", mark.chi2);
    summary.set(to + "/used", mark.rejection.empty());
    if (!mark.rejection.empty()) summary.set(to + "/left_out", mark.rejection);
  }
}

void say_result(Console& console, const analyze::VerifyResult& result, const Flags& flags) {
  console.say(format(
      "%s: light on '%s' lies %.3f mm rms from its place, %.3f at most (%d marks; chi-square %.1f of "
      "%d, limit %.1f at a false-alarm rate of %g)",
      result.alarm ? "ALARM" : "all well", result.surface.c_str(), 1e3 * result.rms, 1e3 * result.worst,
      result.used, result.chi2, result.degrees_of_freedom, result.limit, flags.options.false_alarm_rate));
  if (result.alarm) {
    console.say("either " + words_of(result.projector_moved));
    if (result.surface_moved) {
      console.say("or     " + words_of(*result.surface_moved));
      const double odds = result.projector_moved.log_evidence - result.surface_moved->log_evidence;
      console.say(format("odds of the first to the second: %s%.3g to 1", std::abs(odds) > 13 ? "beyond " : "",
                         std::exp(std::clamp(odds, -13.8, 13.8))));
    }
  }
  if (result.rig || result.rig_from_surface)
    console.say(
        format("corrected: %.3f mm rms, %.3f at most", 1e3 * result.rms_after, 1e3 * result.worst_after));
  console.say(format("residual RMS without movement: %.3f mm, %.2f times the detected noise",
                     1e3 * result.scatter_rms, result.scatter));
  Summary& summary = console.summary();
  summary.set("/alarm", result.alarm);
  summary.set("/surface", result.surface);
  summary.set("/rms_mm", 1e3 * result.rms);
  summary.set("/worst_mm", 1e3 * result.worst);
  summary.set("/rms_after_mm", 1e3 * result.rms_after);
  summary.set("/worst_after_mm", 1e3 * result.worst_after);
  summary.set("/chi2", result.chi2);
  summary.set("/degrees_of_freedom", result.degrees_of_freedom);
  summary.set("/chi2_limit", result.limit);
  summary.set("/false_alarm_rate", flags.options.false_alarm_rate);
  summary.set("/marks_used", result.used);
  summary.set("/scatter", result.scatter);
  summary.set("/scatter_rms_mm", 1e3 * result.scatter_rms);
  summarize(result.projector_moved, "/projector_moved", summary);
  if (result.surface_moved) {
    summarize(*result.surface_moved, "/surface_moved", summary);
    summary.set("/log_odds_projector",
                result.projector_moved.log_evidence - result.surface_moved->log_evidence);
  }
  say_marks(console, result);
}

/// The calibration's own provenance, and what was done to it here.
Provenance with_correction(Provenance provenance, const analyze::VerifyResult& result, const Flags& flags,
                           const Captures& captures) {
  std::string& note = provenance.options["corrected"];
  note += (note.empty() ? "" : "; ") +
          format("verify-projection %s, %s: ", PROCAM_VERSION, utc_now().c_str()) +
          words_of(result.projector_moved) +
          format(" of %.3f on '%s' (%s)", 1e3 * result.rms, result.surface.c_str(), captures.pattern.c_str());
  provenance.inputs.push_back({flags.rig, io::sha256_of_file(flags.rig)});
  provenance.inputs.insert(provenance.inputs.end(), captures.inputs.begin(), captures.inputs.end());
  return provenance;
}

/// The asked-for file in any case: without an alarm nothing is corrected, and it says what was stated before.
void write_corrected(Console& console, const analyze::VerifyResult& result, const Flags& flags,
                     const Captures& captures, const Rig& rig, SurfaceSet surfaces,
                     const Pose& rig_from_frame) {
  if (flags.output.empty()) return;
  if (!result.alarm) console.say("nothing is corrected: " + flags.output + " is as it was");
  if (flags.options.correct == analyze::Correct::kProjector) {
    Rig corrected = result.rig.value_or(rig);
    if (result.rig) corrected.provenance = with_correction(rig.provenance, result, flags, captures);
    io::save_rig(flags.output, corrected);
  } else {
    if (result.rig_from_surface)
      plane_of(pick_surface(surfaces, flags)).frame_from_surface =
          (rig_from_frame.inverse() * result.rig_from_surface->pose).normalized();
    io::save_surfaces(flags.output, surfaces);
  }
}

ExitCode verify_projection(Flags flags, Console& console) {
  for (const std::string& file : {flags.output, flags.picture})
    if (!file.empty()) io::require_writable(file);
  const Rig rig = io::load_rig(flags.rig);
  const RigCamera& camera = rig.camera(flags.camera);
  const RigProjector& projector = rig.projector(flags.projector);
  SurfaceSet surfaces = io::load_surfaces(flags.surfaces);
  Surface& surface = pick_surface(surfaces, flags);
  flags.surface = surface.name;
  const PlanarSurface& plane = plane_of(surface);
  const Captures captures = read_captures(flags, projector, camera);
  const KnownWorld frame = frame_of(plane, flags, rig, camera, projector, captures.light.flat_lit);
  const analyze::StatedSurface stated = state_surface(surface, plane, frame, flags.map_sigma);

  const analyze::VerifyResult result =
      analyze::verify(rig, camera, projector, stated, captures.light.points, flags.options);
  write_corrected(console, result, flags, captures, rig, surfaces, frame.rig_from_world.pose);
  if (!flags.picture.empty())
    io::write_file_atomically(
        flags.picture,
        report::verify_picture(result, content_outline(surface, projector, frame.rig_from_world.pose)));

  say_result(console, result, flags);
  Diagnostics diagnostics = captures.light.diagnostics;
  diagnostics.append(frame.diagnostics);
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
      {"verify-projection",
       "Measures with the rig's camera whether the projector's light agrees with the rig file: millimetres "
       "per mark, an alarm if something has moved (exit 5), and the correction of the projector's or the "
       "surface's pose.",
       "verify-projection --rig rig.json --surfaces surfaces.json --surface wall --captures check/view_00"},
      [&](CLI::App& app) { declare(app, flags); },
      [&](Console& console) { return verify_projection(flags, console); });
}
