/// plan-projection: a data sheet + a place -> what the projector will do on the wall, and plan.svg.
#include <CLI/CLI.hpp>

#include "common/cli.hpp"
#include "procam/analyze/planner.hpp"
#include "procam/io/files.hpp"
#include "procam/io/text.hpp"
#include "procam/report/plan.hpp"

namespace procam::tools {
namespace {

struct Flags {
  analyze::DataSheet sheet;
  std::vector<double> lens_shift = {0, 0};
  double distance = 0, yaw = 0, pitch = 0, roll = 0;
  analyze::Site site;
  std::optional<Vec2> target_size, target_centre;
  std::string output;
};

/// "1.2mx0.8m", "0.2m,-0.3m" -> metres.
Vec2 parse_lengths(const std::string& text, char between, const std::string& example) {
  const std::size_t at = text.find(between);
  if (at == std::string::npos)
    throw Error(ErrorKind::kInput, "'" + text + "'",
                "it needs two lengths with '" + std::string(1, between) + "' between them",
                "give e.g. " + example);
  return Vec2(io::parse_length(text.substr(0, at)), io::parse_length(text.substr(at + 1)));
}

CLI::Option* add_length(CLI::App& app, const std::string& flag, std::optional<double>& value,
                        const std::string& help) {
  return add_parsed(
      app, flag, [&value](const std::string& text) { value = io::parse_length(text); }, help);
}
CLI::Option* add_angle(CLI::App& app, const std::string& flag, double& value, const std::string& help) {
  return add_parsed(
      app, flag, [&value](const std::string& text) { value = io::parse_angle(text); }, help);
}

void declare(CLI::App& app, Flags& flags) {
  analyze::DataSheet& sheet = flags.sheet;
  add_parsed(
      app, "--resolution", [&](const std::string& text) { sheet.resolution = io::parse_size(text); },
      "Data sheet: native resolution, e.g. 1280x800")
      ->required();
  app.add_option("--throw-ratio", sheet.throw_ratio,
                 "Data sheet: distance over image width, e.g. 0.8; for a zoom lens, at the zoom in use")
      ->required();
  app.add_option("--lens-shift", flags.lens_shift,
                 "Data sheet: offset of the optical axis from the centre of the image, in image widths and "
                 "heights, right and down, e.g. 0,0.5 for an axis at the bottom edge (default 0,0)")
      ->delimiter(',')
      ->expected(2);
  app.add_option("--lumens", sheet.lumens, "Data sheet: light of a white image, for the illuminance");
  app.add_option("--f-number", sheet.f_number, "Data sheet: with --focal-length, for the depth of field");
  add_length(app, "--focal-length", sheet.focal_length, "Data sheet: e.g. 14mm");

  add_parsed(
      app, "--distance", [&](const std::string& text) { flags.distance = io::parse_length(text); },
      "Perpendicular distance of the lens from the wall, e.g. 1.5m; the foot of the perpendicular "
      "is the origin of the wall")
      ->required();
  add_angle(app, "--yaw", flags.yaw, "Rotation to the right, e.g. 20deg (default 0deg: facing the wall)");
  add_angle(app, "--pitch", flags.pitch, "Then rotation upwards, e.g. -10deg");
  add_angle(app, "--roll", flags.roll, "Then clockwise rotation as seen from behind, e.g. 2deg");

  auto* target = add_parsed(
      app, "--target",
      [&](const std::string& text) { flags.target_size = parse_lengths(text, 'x', "1.2mx0.8m"); },
      "Area to cover, width x height, e.g. 1.2mx0.8m");
  add_parsed(
      app, "--target-at",
      [&](const std::string& text) { flags.target_centre = parse_lengths(text, ',', "0.2m,-0.3m"); },
      "Centre of the area, right and down from the origin of the wall, e.g. 0.2m,-0.3m (default: "
      "where it fits best)")
      ->needs(target);
  add_length(app, "--viewer-distance", flags.site.viewer_distance,
             "Distance of the reader from the wall, e.g. 3m");
  add_length(app, "--text-height", flags.site.text_height,
             "Height of the smallest capital letters, e.g. 20mm");
  app.add_option("-o,--output", flags.output, "Also draw the plan, .svg");
}

ExitCode plan(Flags flags, Console& console) {
  flags.sheet.lens_shift = Vec2(flags.lens_shift[0], flags.lens_shift[1]);
  flags.site.projector_from_wall =
      analyze::pose_before_wall(flags.distance, flags.yaw, flags.pitch, flags.roll);
  if (flags.target_size) flags.site.target = analyze::WallTarget{*flags.target_size, flags.target_centre};

  const analyze::ProjectionPlan planned = analyze::plan_projection(flags.sheet, flags.site);
  if (!flags.output.empty()) io::write_file_atomically(flags.output, report::plan_picture(planned));

  console.say(report::lines(planned));
  console.summary().merge(report::to_json(planned));
  console.report(planned.diagnostics);
  if (!flags.output.empty()) {
    console.summary().set("/files", std::vector<std::string>{flags.output});
    console.say("wrote " + flags.output);
  }
  return exit_code(planned.diagnostics);
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  Flags flags;
  return run_tool(
      argc, argv,
      {"plan-projection",
       "Predicts the image of a projector on a wall from its data sheet and its pose: size, pixels, light, "
       "sharpness, readable text and coverage. Draws a plan."},
      [&](CLI::App& app) { declare(app, flags); }, [&](Console& console) { return plan(flags, console); });
}
