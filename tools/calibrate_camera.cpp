/// calibrate-camera: photographs of a printed board, or a table of its points and pixels -> rig.json with the
/// cameras alone.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <system_error>

#include "common/cli.hpp"
#include "common/lens_flags.hpp"
#include "common/rig_words.hpp"
#include "common/say_choices.hpp"
#include "procam/calibrate/calibrate.hpp"
#include "procam/detect/detect_board.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/files.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/session/observations_file.hpp"
#include "procam/io/text.hpp"
#include "procam/report/calibration.hpp"
#include "procam/session/join.hpp"
#include "procam/session/reader.hpp"

namespace procam::tools {
namespace {

namespace fs = std::filesystem;

struct Flags {
  fs::path images, observations, output, report, write_observations;
  std::optional<Board> board;
  std::vector<Device> cameras;  ///< of a table of observations
  std::string model = kAutoModel;
  std::vector<std::string> free, fixed;
  std::string board_shape = "auto";
  bool holdout = false, keep_outliers = false;
};

const std::map<std::string, calibrate::BoardShape>& board_shapes() {
  static const std::map<std::string, calibrate::BoardShape> names{{"auto", calibrate::BoardShape::kAuto},
                                                                  {"flat", calibrate::BoardShape::kFlat},
                                                                  {"free", calibrate::BoardShape::kFree}};
  return names;
}

void declare(CLI::App& app, Flags& flags) {
  auto* images = app.add_option("--images", flags.images,
                                "Folder of photographs, one a board pose; files of other kinds are ignored");
  auto* table = app.add_option("--observations", flags.observations,
                               "Instead of images: a table of board points and pixels, .csv or .npy "
                               "(docs/file-formats.md); rows of projectors are ignored")
                    ->excludes(images);
  add_parsed(
      app, "--camera-size",
      [&](const std::string& text) { flags.cameras.push_back(io::parse_device(text, DeviceKind::kCamera)); },
      "Size of the camera's images, where a table does not give it; of several cameras one for each: "
      "left=1280x1024")
      ->trigger_on_parse()
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast)
      ->needs(table);
  add_parsed(
      app, "--board", [&](const std::string& text) { flags.board = io::read_board(text); },
      "The printed board, e.g. chessboard:7x9:75mm (inner corners); needed with --images");
  app.add_option("-o,--output", flags.output, "Rig file to write")->required();
  app.add_option("--write-observations", flags.write_observations,
                 "Also write the points and pixels that were found, as --observations reads them");
  app.add_option("--report", flags.report, "Also write a self-contained HTML page");
  app.add_option("--board-shape", flags.board_shape,
                 "Is the board flat, as printed? auto: by the prediction of held-out views; flat; free: "
                 "every point may be off its position by about 1 % of a square")
      ->check(CLI::IsMember(board_shapes()))
      ->capture_default_str();
  app.add_flag("--keep-outliers", flags.keep_outliers, "Reject no point and no view");
  app.add_flag("--holdout", flags.holdout, "Report how well each view is predicted by a solve without it");
  app.add_option("--camera-model", flags.model, std::string("The lens: ") + kLensModelHelp + " or fisheye")
      ->capture_default_str();
  app.add_option("--free", flags.free, "Accepted for older scripts: skew and k3 are estimated anyway")
      ->check(CLI::IsMember({"skew", "k3"}))
      ->delimiter(',');
  app.add_option("--fix", flags.fixed, "Keep skew or k3 at zero, for a program that has none")
      ->check(CLI::IsMember({"skew", "k3"}))
      ->delimiter(',');
  app.callback([&flags] {
    if (flags.images.empty() && flags.observations.empty())
      throw CLI::RequiredError("--images DIR or --observations FILE");
    if (!flags.images.empty() && !flags.board) throw CLI::RequiredError("--board with --images");
  });
}

ExitCode calibrate_alone(const Flags& flags, Console& console) {
  for (const fs::path& file : {flags.output, flags.report, flags.write_observations})
    if (!file.empty()) io::require_writable(file);
  const session::SessionContents input =
      flags.observations.empty()
          ? session::read_board_images(flags.images, *flags.board,
                                       [&](const std::string& name, int done, int total) {
                                         console.progress("reading " + name, done, total);
                                       })
          : session::read_observations(flags.observations, flags.cameras, flags.board);
  if (!flags.write_observations.empty())
    io::save_observations(flags.write_observations, input.correspondences);
  calibrate::Options options;
  options.holdout = flags.holdout;
  options.board_shape = board_shapes().at(flags.board_shape);
  if (flags.keep_outliers) options.outlier_sigmas = 0;
  set_lens_model(flags.model, flags.fixed, options.camera);
  calibrate::CalibrationResult result = calibrate::calibrate_camera(input.correspondences, options);
  Rig& rig = result.rig;
  rig.provenance = session::provenance(input, "calibrate-camera");
  for (const auto& [option, choice] :
       {std::pair("camera-model", flags.model), std::pair("board-shape", flags.board_shape)})
    if (choice != "auto") rig.provenance.options[option] = choice;
  if (flags.keep_outliers) rig.provenance.options["keep-outliers"] = "yes";
  for (const std::string& name : flags.fixed) rig.provenance.options["fix " + name] = "yes";
  io::save_rig(flags.output, rig);
  if (!flags.report.empty()) {
    report::ReportInput extra;
    extra.title = input.title;
    Correspondences cameras = input.correspondences;  // as calibrate_camera takes them
    cameras.devices = result.devices;
    for (View& view : cameras.views) {
      view.observations.resize(result.devices.size());
      view.light_points.clear();
    }
    io::write_file_atomically(flags.report, report::calibration_report(result, cameras, extra));
  }

  const bool passed = rig.quality.passed();
  console.say(format("result     %s: RMS %.3f px (outliers included: %.3f), %d of %d views used",
                     passed ? "passed" : "do not use", result.joint_rms_px, result.joint_rms_all_px,
                     rig.quality.views_used, input.views));
  console.summary().set("/result", passed ? "passed" : "failed");
  say_remarks(console, result.diagnostics);
  console.summary().set("/views_used", rig.quality.views_used);
  console.summary().set("/views", input.views);
  console.summary().set("/rms_px", result.joint_rms_px);
  console.summary().set("/rms_all_px", result.joint_rms_all_px);
  for (std::size_t d = 0; d < result.devices.size() && flags.holdout; ++d) {
    const std::string& device = result.devices[d].name;
    console.say(format("held out   %s %.3f px; each view predicted by a solve without it", device.c_str(),
                       result.holdout_px[d]));
    console.summary().set("/holdout_px/" + device, result.holdout_px[d]);
  }
  for (const RigCamera& device : rig.cameras) {
    const VecX values = parameters_of(device.camera);
    const std::vector<std::string> names = parameter_names(device.camera);
    if (rig.cameras.size() > 1) console.say(device.name);
    for (std::size_t i = 0; i < names.size(); ++i) {
      const double value = values[Eigen::Index(i)],
                   sigma = rig.covariance.sigma(device.name + "." + names[i]);
      console.say(
          format("%-6s %12.5f +- %.5f%s", names[i].c_str(), value, sigma, sigma > 0 ? "" : "  fixed"));
      console.summary().set("/" + device.name + "/" + names[i], value);
      console.summary().set("/" + device.name + "/sigma/" + names[i], sigma);
    }
  }
  say_board_shape(console, result);
  say_size_to_measure(console, result);
  say_lens_models(console, result, 0);
  say_gates(console, rig.quality.gates);
  console.say("written    " + flags.output.string() +
              (flags.report.empty() ? "" : ", " + flags.report.string()));
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
       "pixels.",
       "calibrate-camera --images photos --board chessboard:7x9:75mm -o camera.json"},
      [&](CLI::App& app) { declare(app, flags); },
      [&](Console& console) { return calibrate_alone(flags, console); });
}
