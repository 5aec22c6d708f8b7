#include "common/calibration_flags.hpp"

#include <CLI/CLI.hpp>

#include "procam/io/files.hpp"
#include "procam/io/text.hpp"
#include "procam/report/files.hpp"

namespace procam::tools {
namespace {

const std::map<std::string, calibrate::BoardShape>& board_shapes() {
  static const std::map<std::string, calibrate::BoardShape> names{{"auto", calibrate::BoardShape::kAuto},
                                                                  {"flat", calibrate::BoardShape::kFlat},
                                                                  {"free", calibrate::BoardShape::kFree}};
  return names;
}

}  // namespace

void declare_calibration(CLI::App& app, CalibrationFlags& flags) {
  app.add_option(
      "--observations", flags.observations,
      "Instead of images: a table of board points and pixels, .csv or .npy (docs/file-formats.md)");
  add_parsed(
      app, "--camera-size",
      [&](const std::string& text) { flags.cameras.push_back(io::parse_device(text, DeviceKind::kCamera)); },
      "Size of the camera's images, where a table of observations or a calibration to check does not give "
      "it; of several cameras one for each: left=1280x1024")
      ->trigger_on_parse()
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  app.add_option("-o,--output", flags.output, "Rig file to write");
  app.add_option("--write-observations", flags.write_observations,
                 "Also write the points and pixels that were found, as --observations reads them");
  app.add_option("--report", flags.report, "Also write a self-contained HTML page");
  app.add_option("--figures", flags.figures, "Also write the page's figures into this folder, as SVG files");
  app.add_option("--data", flags.data,
                 "Also write parameters, covariance, views and residuals into this folder, as CSV files");
  app.add_option("--board-shape", flags.board_shape,
                 "Is the board flat, as printed? auto: by the prediction of held-out views; flat; free: "
                 "every point may be off its position by about 1 % of a square")
      ->check(CLI::IsMember(board_shapes()))
      ->capture_default_str();
  app.add_flag("--keep-outliers", flags.keep_outliers, "Reject no point and no view, however far off");
  app.add_flag("--holdout", flags.holdout, "Report how well each view is predicted by a solve without it");
  app.add_option("--fix", flags.fixed,
                 "Keep skew or k3 of camera and projector at zero, for a program that has none")
      ->check(CLI::IsMember({"skew", "k3"}))
      ->delimiter(',');
}

void require_outputs(const CalibrationFlags& flags) {
  for (const std::filesystem::path& file : {flags.output, flags.report, flags.write_observations})
    if (!file.empty()) io::require_writable(file);
  for (const std::filesystem::path& folder : {flags.figures, flags.data})
    if (!folder.empty()) report::require_folder(folder);
}

void write_report(const CalibrationFlags& flags, const calibrate::CalibrationResult& result,
                  const Correspondences& correspondences, const report::ReportInput& input) {
  if (!flags.data.empty()) report::save_files(flags.data, report::calibration_tables(result));
  if (flags.report.empty() && flags.figures.empty()) return;
  const std::string page = report::calibration_report(result, correspondences, input);
  if (!flags.report.empty()) io::write_file_atomically(flags.report, page);
  if (!flags.figures.empty()) report::save_files(flags.figures, report::figures(page));
}

calibrate::Options calibration_options(const CalibrationFlags& flags) {
  calibrate::Options options;
  options.holdout = flags.holdout;
  options.board_shape = board_shapes().at(flags.board_shape);
  if (flags.keep_outliers) options.outlier_sigmas = 0;
  return options;
}

void add_options(const CalibrationFlags& flags, const std::map<std::string, std::string>& models,
                 Provenance& provenance) {
  for (const std::string& name : flags.fixed) provenance.options["fix " + name] = "yes";
  if (flags.keep_outliers) provenance.options["keep-outliers"] = "yes";
  if (flags.board_shape != "auto") provenance.options["board-shape"] = flags.board_shape;
  for (const auto& [flag, model] : models)
    if (model != "auto") provenance.options[flag] = model;
}

std::string written_line(const CalibrationFlags& flags) {
  std::string line = "written    " + flags.output.string();
  for (const std::filesystem::path& path : {flags.report, flags.figures, flags.data})
    if (!path.empty()) line += ", " + path.string();
  return line;
}

}  // namespace procam::tools
