/// calibrate-camera: photographs of a printed board, or a table of its points and pixels -> rig.json with the
/// cameras alone.
#include <CLI/CLI.hpp>
#include <filesystem>

#include "common/calibration_flags.hpp"
#include "common/lens_flags.hpp"
#include "procam/calibrate/calibrate.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/files.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/session/observations_file.hpp"
#include "procam/io/text.hpp"
#include "procam/report/calibration.hpp"
#include "procam/session/reader.hpp"

namespace procam::tools {
namespace {

namespace fs = std::filesystem;

struct Flags : CalibrationFlags {
  fs::path images;
  std::optional<Board> board;
  std::string model = kAutoModel;
};

void declare(CLI::App& app, Flags& flags) {
  declare_calibration(app, flags);
  CLI::Option* table = app.get_option("--observations");
  app.add_option("--images", flags.images,
                 "Folder of photographs, one a board pose; files of other kinds are ignored")
      ->excludes(table);
  app.get_option("--camera-size")->needs(table);
  app.get_option("--output")->required();
  add_parsed(
      app, "--board", [&](const std::string& text) { flags.board = io::read_board(text); },
      "The printed board, e.g. charuco:5x7:34mm:25mm:5x5_100 or chessboard:9x6:24mm (inner corners); needed with --images");
  app.add_option("--camera-model", flags.model, std::string("The lens: ") + kLensModelHelp + " or fisheye")
      ->capture_default_str();
  app.add_option("--free", flags.free, "Accepted for older scripts: skew and k3 are estimated anyway")
      ->check(CLI::IsMember({"skew", "k3"}))
      ->delimiter(',');
  app.callback([&flags] {
    if (flags.images.empty() && flags.observations.empty())
      throw CLI::RequiredError("--images DIR or --observations FILE");
    if (!flags.images.empty() && !flags.board) throw CLI::RequiredError("--board with --images");
  });
}

ExitCode calibrate_alone(const Flags& flags, Console& console) {
  require_outputs(flags);
  const session::SessionContents input =
      flags.observations.empty()
          ? session::read_board_images(flags.images, *flags.board,
                                       [&](const std::string& name, int done, int total) {
                                         console.progress("reading " + name, done, total);
                                       })
          : session::read_observations(flags.observations, flags.cameras, flags.board);
  if (!flags.write_observations.empty())
    io::save_observations(flags.write_observations, input.correspondences);
  calibrate::Options options = calibration_options(flags);
  set_lens_model(flags.model, flags.fixed, options.camera);
  calibrate::CalibrationResult result = console.reporting(input.correspondences.diagnostics, [&] {
    return calibrate::calibrate_camera(input.correspondences, options);
  });
  result.rig.provenance = session::provenance(input, "calibrate-camera");
  add_options(flags, {{"camera-model", flags.model}}, result.rig.provenance);
  io::save_rig(flags.output, result.rig);
  report::ReportInput summary;
  summary.title = input.title;
  summary.views = input.views;
  summary.images = input.view_images;
  Correspondences cameras = input.correspondences;  // as calibrate_camera takes them
  cameras.devices = result.devices;
  for (View& view : cameras.views) {
    view.observations.resize(result.devices.size());
    view.light_points.clear();
  }
  write_report(flags, result, cameras, summary);

  console.say(report::headline(result, summary));
  console.report(result.diagnostics);
  console.say(report::lines(result, summary));
  console.say(written_line(flags));
  console.summary().merge(report::to_json(result, summary));
  return exit_code(result.diagnostics);
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  Flags flags;
  return run_tool(
      argc, argv,
      {"calibrate-camera",
       "Calibrates cameras alone from photographs of a printed board, or from a table of its points and "
       "pixels."},
      [&](CLI::App& app) { declare(app, flags); },
      [&](Console& console) { return calibrate_alone(flags, console); });
}
