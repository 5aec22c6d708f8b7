/// calibrate-camera: photographs of a printed board -> rig.json with the camera alone.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <set>
#include <system_error>

#include "common/cli.hpp"
#include "common/identical_files.hpp"
#include "common/lens_flags.hpp"
#include "common/say_choices.hpp"
#include "common/utc_now.hpp"
#include "procam/calibrate/calibrate.hpp"
#include "procam/detect/detect_board.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/files.hpp"
#include "procam/io/images.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/text.hpp"
#include "procam/match/join.hpp"

namespace procam::tools {
namespace {

namespace fs = std::filesystem;

struct Flags {
  fs::path images, output;
  std::optional<Board> board;
  std::string model = kAutoModel;
  std::vector<std::string> free, fixed;
};

void declare(CLI::App& app, Flags& flags) {
  app.add_option("--images", flags.images, "folder of photographs, one a board pose; others are left alone")
      ->required();
  add_parsed(
      app, "--board", [&](const std::string& text) { flags.board = io::read_board(text); },
      "The printed board, e.g. chessboard:7x9:75mm (inner corners)")
      ->required();
  app.add_option("-o,--output", flags.output, "Rig file to write")->required();
  app.add_option("--camera-model", flags.model, std::string("The lens: ") + kLensModelHelp + " or fisheye")
      ->capture_default_str();
  app.add_option("--free", flags.free, "Accepted for older scripts: skew and k3 are estimated anyway")
      ->check(CLI::IsMember({"skew", "k3"}))
      ->delimiter(',');
  app.add_option("--fix", flags.fixed, "Keep skew or k3 at zero, for a program that has none")
      ->check(CLI::IsMember({"skew", "k3"}))
      ->delimiter(',');
}

/// In natural order of their names.
std::vector<fs::path> images_in(const fs::path& folder) {
  const std::set<std::string> kEndings{".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff"};
  std::vector<fs::path> files;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    std::string ending = entry.path().extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; });
    if (kEndings.count(ending) != 0) files.push_back(entry.path());
  }
  if (error) throw Error(ErrorKind::kIo, folder.string(), error.message(), "give a folder of photographs");
  if (files.empty())
    throw Error(ErrorKind::kInput, folder.string(), "it holds no image",
                "give a folder of photographs (png, jpg, bmp, tif), one a board pose");
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return io::natural_less(a.filename().string(), b.filename().string());
  });
  return files;
}

Correspondences read_views(const Flags& flags, const std::vector<fs::path>& files, Console& console,
                           std::vector<InputFile>& inputs) {
  std::vector<match::BoardView> views;
  for (std::size_t i = 0; i < files.size(); ++i) {
    console.progress("reading " + files[i].filename().string(), int(i), int(files.size()));
    const ImageU8 grey = io::to_gray(io::load_image(files[i]).image);
    inputs.push_back({files[i].filename().string(), io::sha256_of_file(files[i])});
    views.push_back({files[i].filename().string(), {detect::detect_board(grey, *flags.board)}});
  }
  const ImageSize size = views.front().detections.front().image_size;
  return match::join(*flags.board, {{"camera", DeviceKind::kCamera, size}}, views);
}

ExitCode calibrate_alone(const Flags& flags, Console& console) {
  io::require_writable(flags.output);
  const std::vector<fs::path> files = images_in(flags.images);
  std::vector<InputFile> inputs;
  const Correspondences correspondences = read_views(flags, files, console, inputs);
  calibrate::Options options;
  set_lens_model(flags.model, flags.fixed, options.camera);
  calibrate::CalibrationResult result = calibrate::calibrate_camera(correspondences, options);
  Rig& rig = result.rig;
  rig.provenance.tool = "calibrate-camera";
  rig.provenance.version = PROCAM_VERSION;
  rig.provenance.created = utc_now();
  rig.provenance.inputs = inputs;
  warn_of_identical_files(inputs, result.diagnostics);
  rig.provenance.options = {{"board", io::format_board(*flags.board)}};
  rig.provenance.options["camera-model"] = flags.model;
  for (const std::string& name : flags.fixed) rig.provenance.options["fix " + name] = "yes";
  io::save_rig(flags.output, rig);

  const bool passed = rig.quality.passed();
  console.say(format("result     %s: RMS %.3f px (outliers included: %.3f), %d of %zu images used",
                     passed ? "passed" : "do not use", result.rms_px[0], result.rms_all_px[0],
                     rig.quality.views_used, files.size()));
  console.summary().set("/result", passed ? "passed" : "failed");
  console.report(result.diagnostics);
  console.summary().set("/views_used", rig.quality.views_used);
  console.summary().set("/views", int(files.size()));
  console.summary().set("/rms_px", result.rms_px[0]);
  console.summary().set("/rms_all_px", result.rms_all_px[0]);
  const Camera& camera = rig.camera().camera;
  const VecX values = parameters_of(camera);
  const std::vector<std::string> names = parameter_names(camera);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const double value = values[Eigen::Index(i)], sigma = rig.covariance.sigma("camera." + names[i]);
    console.say(format("%-6s %12.5f +- %.5f%s", names[i].c_str(), value, sigma, sigma > 0 ? "" : "  fixed"));
    console.summary().set("/camera/" + names[i], value);
    console.summary().set("/camera/sigma/" + names[i], sigma);
  }
  say_lens_models(console, result, 0);
  for (const Gate& gate : rig.quality.gates)
    if (!gate.passed) console.say("check FAILED " + gate.name + ": " + gate.detail);
  console.say("wrote " + flags.output.string());
  return exit_code(result.diagnostics);
}

}  // namespace
}  // namespace procam::tools

int main(int argc, char** argv) {
  using namespace procam::tools;
  Flags flags;
  return run_tool(
      argc, argv,
      {"calibrate-camera", "Calibrates a camera alone from photographs of a printed board.",
       "calibrate-camera --images photos --board chessboard:7x9:75mm -o camera.json"},
      [&](CLI::App& app) { declare(app, flags); },
      [&](Console& console) { return calibrate_alone(flags, console); });
}
