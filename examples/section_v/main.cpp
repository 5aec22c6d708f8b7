/// section_v: where the corners of a sheet land, simulated or measured with a ruler -> table and
/// page.
#include <CLI/CLI.hpp>
#include <cmath>
#include <map>

#include "common/cli.hpp"
#include "evaluation_page.hpp"
#include "measured_corners.hpp"
#include "procam/io/files.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/text.hpp"
#include "sheet_experiment.hpp"

namespace procam::section_v {
namespace {

using tools::Console;
using tools::exit_code;
using tools::ExitCode;

using tools::Summary;

struct Flags {
  std::string rig, truth, measured, units, report, corners;
  bool original = false;
  double noise_grey = 2;
  std::uint64_t seed = 1;
};

/// Of the system that procam succeeds: reprojection error of its calibration, and how far from their places
/// the corners of its two sheets landed.
constexpr double kOriginalPixelRms = 1.54;
constexpr double kOriginalMeanMm[] = {12, 20};

void declare(CLI::App& app, Flags& flags) {
  auto* rig = app.add_option("--rig", flags.rig, "the rig on trial, as calibrate-projector writes it");
  auto* truth =
      app.add_option("--truth", flags.truth,
                     "the true rig (simulate-captures leaves truth.json): the experiment is simulated");
  auto* measured = app.add_option("--measured", flags.measured,
                                  "points.csv, the corners' places measured with a ruler: sheet, placement, "
                                  "distance_m, incidence_deg, corner, physical_x, physical_y, projected_x, "
                                  "projected_y");
  auto* units = app.add_option("--units", flags.units, "of the places in points.csv: mm, cm, m or in")
                    ->check(CLI::IsMember({"mm", "cm", "m", "in"}));
  auto* original = app.add_flag("--original", flags.original,
                                "instead of --rig: a calibration as bad as that of the original system (1.54 "
                                "px), and what its 12 and 20 mm come from");
  measured->needs(units);
  units->needs(measured);
  measured->excludes(truth)->excludes(original);
  original->excludes(rig)->needs(truth);
  app.add_option("--noise", flags.noise_grey, "of the simulated camera, sigma in grey levels")
      ->check(CLI::Range(0.0, 64.0))
      ->capture_default_str();
  app.add_option("--seed", flags.seed, "of placements and noise")->capture_default_str();
  app.add_option("--report", flags.report, "Also write a self-contained HTML page");
  app.add_option("--corners", flags.corners,
                 "Also write every corner, as --measured --units cm reads them, .csv");
  app.callback([=] {
    if (measured->count() == 0 && truth->count() == 0) throw CLI::RequiredError("--truth or --measured");
    if (truth->count() > 0 && rig->count() + original->count() == 0)
      throw CLI::RequiredError("--rig or --original");
  });
}

std::string mm(double value) {
  return format("%.2f mm", value);
}

void require_devices(const Rig& rig, const std::string& file) {
  if (rig.cameras.empty() || rig.projectors.empty())
    throw Error(ErrorKind::kInput, file, "it has no camera or no projector", "give a rig with one of each");
}

/// What was found, and the verdict's sentences, the most important first.
struct Outcome {
  Evaluation evaluation;
  std::vector<std::string> verdict;
};

Outcome simulate_trial(const Flags& flags, Console& console, Diagnostics& diagnostics) {
  const Rig truth = io::load_rig(flags.truth), rig = io::load_rig(flags.rig);
  require_devices(truth, flags.truth);
  require_devices(rig, flags.rig);
  for (const auto& [a, b, what] :
       {std::tuple(rig.cameras.front().camera.size, truth.cameras.front().camera.size, "camera"),
        std::tuple(rig.projectors.front().projector.size(), truth.projectors.front().projector.size(),
                   "projector")})
    if (a != b)
      throw Error(ErrorKind::kInput, flags.rig,
                  "its " + std::string(what) + " has " + std::to_string(a.width) + "x" +
                      std::to_string(a.height) + " pixels, the true one " + std::to_string(b.width) + "x" +
                      std::to_string(b.height),
                  "give the truth that the rig was calibrated from");
  const std::vector<Sheet> sheets = original_sheets();
  const Projector& projector = truth.projectors.front().projector;
  const std::vector<SheetPlacement> placements = original_placements(projector, sheets, flags.seed);
  const SheetExperiment experiment =
      run_sheet_experiment(placements, sheets, truth, rig, flags.noise_grey, flags.seed,
                           [&](int i) { console.progress("placement", i + 1, int(placements.size())); });
  if (experiment.unseen > 0)
    diagnostics.warn("marker_unseen", std::to_string(experiment.unseen) + " of " +
                                          std::to_string(placements.size()) +
                                          " sheets carry a marker that the camera does not see well enough");
  if (rig.covariance.empty())
    diagnostics.warn("no_calibration_covariance",
                     flags.rig +
                         ": it carries no covariance, nothing is predicted; calibrate with "
                         "calibrate-projector to have one");
  Outcome outcome{evaluate(sheets, experiment.placements, projector), {}};
  outcome.evaluation.rig = truth;
  const Evaluation true_pose = evaluate(sheets, experiment.with_true_pose, projector),
                   true_calibration = evaluate(sheets, experiment.with_true_calibration, projector);
  for (std::size_t i = 0; i < outcome.evaluation.results.size(); ++i) {
    const SheetEvaluation& one = outcome.evaluation.results[i];
    outcome.verdict.push_back("Sheet at " + one.sheet.name + ": the projected corners are " +
                              mm(one.median_mm) + " off (median; largest " + mm(one.worst_mm) + ").");
    outcome.verdict.push_back(one.sheet.name + ": " + mm(true_calibration.results[i].median_mm) +
                              " with a perfect calibration (marker detection noise only).");
    outcome.verdict.push_back(
        one.sheet.name + ": " + mm(true_pose.results[i].median_mm) +
        " if the pose came from an external tracker: calibration errors shared by camera and projector then no "
        "longer cancel.");
    const std::string at = "/sheets/" + std::to_string(i);
    console.summary().set(at + "/with_true_pose_median_mm", true_pose.results[i].median_mm);
    console.summary().set(at + "/with_true_calibration_median_mm", true_calibration.results[i].median_mm);
  }
  return outcome;
}

Outcome reproduce_original(const Flags& flags, Console& console) {
  const Rig truth = io::load_rig(flags.truth);
  require_devices(truth, flags.truth);
  const std::vector<Sheet> sheets = original_sheets();
  const Projector& projector = truth.projectors.front().projector;
  std::vector<SheetPlacement> placements = original_placements(projector, sheets, flags.seed);
  CrudeCalibration crude{kOriginalPixelRms, {}};
  for (int i = 0; i < int(sheets.size()); ++i) {
    console.progress("sheet", i + 1, int(sheets.size()));
    crude.turn.push_back(
        turn_explaining(placements, sheets, i, projector, crude.pixel_rms, kOriginalMeanMm[i], flags.seed));
  }
  draw_crude_landings(placements, sheets, projector, {crude.pixel_rms, {0, 0}}, flags.seed);
  const Evaluation pixels_alone = evaluate(sheets, placements, projector);
  draw_crude_landings(placements, sheets, projector, {0, crude.turn}, flags.seed);
  const Evaluation turn_alone = evaluate(sheets, placements, projector);
  draw_crude_landings(placements, sheets, projector, crude, flags.seed);
  Outcome outcome{evaluate(sheets, placements, projector), {}};
  outcome.evaluation.rig = truth;
  outcome.verdict.push_back("The original's 12 and 20 mm are an angular bias, not its reprojection error.");
  for (std::size_t i = 0; i < outcome.evaluation.results.size(); ++i) {
    const SheetEvaluation& one = outcome.evaluation.results[i];
    const double turn_deg = crude.turn[i] / kDegree;
    outcome.verdict.push_back(format(
        "%s: %.1f mm mean. Its reprojection error of %.2f px explains %.1f mm; all light turned by %.2f "
        "degrees explains the rest (%.1f mm alone).",
        one.sheet.name.c_str(), one.mean_mm, crude.pixel_rms, pixels_alone.results[i].mean_mm, turn_deg,
        turn_alone.results[i].mean_mm));
    const std::string at = "/sheets/" + std::to_string(i);
    console.summary().set(at + "/pixels_alone_mean_mm", pixels_alone.results[i].mean_mm);
    console.summary().set(at + "/turn_alone_mean_mm", turn_alone.results[i].mean_mm);
    console.summary().set(at + "/turn_deg", turn_deg);
  }
  return outcome;
}

/// The lens of a projector of whom nothing is known but the light's directions.
Projector nominal_projector() {
  return Projector{Camera{{1024, 768}, {1900.0, 1900.0, 511.5, 383.5, 0.0}, NoDistortion{}}};
}

Outcome evaluate_measured(const Flags& flags) {
  const std::vector<MeasuredCorner> corners =
      load_measured_corners(flags.measured, io::parse_length("1" + flags.units));
  Projector projector = nominal_projector();
  if (!flags.rig.empty()) {
    const Rig rig = io::load_rig(flags.rig);
    require_devices(rig, flags.rig);
    projector = rig.projectors.front().projector;
  }
  std::vector<Sheet> sheets;
  std::vector<Eigen::AlignedBox2d> extents;
  std::map<std::string, int> sheet_named;
  for (const MeasuredCorner& corner : corners) {
    const auto [at, is_new] = sheet_named.emplace(corner.sheet, int(sheets.size()));
    if (is_new) {
      sheets.push_back({corner.sheet, Vec2::Zero(), corner.incidence_deg});
      extents.emplace_back();
    }
    extents[std::size_t(at->second)].extend(corner.physical);
  }
  for (std::size_t i = 0; i < sheets.size(); ++i) sheets[i].size = extents[i].sizes();
  // In the middle of the picture, as far as anybody knows.
  const Vec2 middle(0.5 * (projector.size().width - 1), 0.5 * (projector.size().height - 1));
  std::vector<SheetPlacement> placements;
  std::map<std::pair<int, int>, std::size_t> placement_of;
  for (const MeasuredCorner& corner : corners) {
    const int sheet = sheet_named.at(corner.sheet);
    const auto [at, is_new] = placement_of.emplace(std::pair(sheet, corner.placement), placements.size());
    if (is_new)
      placements.push_back(
          {sheet,
           corner.distance,
           place_sheet(projector, sheets[std::size_t(sheet)], middle, corner.distance, false, 0),
           {}});
    const Vec2 origin = extents[std::size_t(sheet)].center();
    placements[at->second].landings.push_back(
        {corner.corner, corner.physical - origin, corner.projected - origin, std::nullopt});
  }
  Outcome outcome{evaluate(sheets, placements, projector), {}};
  for (const SheetEvaluation& one : outcome.evaluation.results) {
    outcome.verdict.push_back("On " + one.sheet.name + " the corners landed " + mm(one.mean_mm) +
                              " from their places (mean of " + std::to_string(one.landings) + "; " +
                              mm(one.worst_mm) + " at worst).");
    if (!one.turn) continue;
    const double share = 100 * one.turn->explained, degrees = one.turn->rotation.norm() / kDegree;
    outcome.verdict.push_back(format(
        "%s: a common rotation of the projector by %.2f degrees would explain %.0f %% of the squared error; "
        "%.2f mm RMS remain%s",
        one.sheet.name.c_str(), degrees, share, one.turn->rest_mm,
        share > 50 ? ": the projector's direction is what to fix, by verify-projection or a new calibration."
                   : ": the error is not a common one; look at the pose of each placement."));
  }
  return outcome;
}

void say(const SheetEvaluation& one, Console& console) {
  console.say(format("%s, %.2f x %.2f cm, %d placements: mean %.2f mm, median %.2f, rms %.2f, worst %.2f",
                     one.sheet.name.c_str(), 100 * one.sheet.size.x(), 100 * one.sheet.size.y(),
                     one.placements, one.mean_mm, one.median_mm, one.rms_mm, one.worst_mm));
  console.say("  corner         physical, cm      projected, median    std                error");
  const char* const names[] = {"top left", "top right", "bottom right", "bottom left"};
  for (std::size_t i = 0; i < 4; ++i) {
    const CornerRow& row = one.corners[i];
    if (row.count == 0) continue;
    console.say(format("  %-13s %7.2f %7.2f   %8.3f %8.3f   %7.3f %7.3f   %8.2f mm", names[i],
                       100 * row.physical.x(), 100 * row.physical.y(), 100 * row.median.x(),
                       100 * row.median.y(), 100 * row.standard_deviation.x(),
                       100 * row.standard_deviation.y(), 1e3 * row.error));
  }
  if (one.predicted_rms_mm > 0) {
    console.say(format("  predicted %.2f mm rms; %.0f %% of the corners inside their 95 %% regions",
                       one.predicted_rms_mm, 100 * one.inside_95));
    for (const analyze::Cause& cause : one.causes)
      console.say(format("  %-22s %8.2f mm alone, %8.2f mm without it", cause.name.c_str(), cause.rms_mm,
                         cause.without_mm));
  }
}

void summarize(const Evaluation& evaluation, Summary& summary) {
  for (std::size_t i = 0; i < evaluation.results.size(); ++i) {
    const SheetEvaluation& one = evaluation.results[i];
    const std::string at = "/sheets/" + std::to_string(i);
    summary.set(at + "/name", one.sheet.name);
    summary.set(at + "/placements", one.placements);
    summary.set(at + "/landings", one.landings);
    summary.set(at + "/mean_mm", one.mean_mm);
    summary.set(at + "/median_mm", one.median_mm);
    summary.set(at + "/rms_mm", one.rms_mm);
    summary.set(at + "/worst_mm", one.worst_mm);
    summary.set(at + "/mm_per_pixel", one.mm_per_pixel);
    if (one.predicted_rms_mm > 0) {
      summary.set(at + "/predicted_rms_mm", one.predicted_rms_mm);
      summary.set(at + "/inside_95", one.inside_95);
    }
    if (one.turn) {
      summary.set(at + "/light_turned_deg", one.turn->rotation.norm() / kDegree);
      summary.set(at + "/light_turned_explains", one.turn->explained);
      summary.set(at + "/light_turned_leaves_mm", one.turn->rest_mm);
    }
    for (std::size_t c = 0; c < 4; ++c) {
      const CornerRow& row = one.corners[c];
      const std::string corner = at + "/corners/" + std::to_string(c);
      summary.set(corner + "/physical_mm",
                  std::vector<double>{1e3 * row.physical.x(), 1e3 * row.physical.y()});
      summary.set(corner + "/median_mm", std::vector<double>{1e3 * row.median.x(), 1e3 * row.median.y()});
      summary.set(corner + "/std_mm",
                  std::vector<double>{1e3 * row.standard_deviation.x(), 1e3 * row.standard_deviation.y()});
      summary.set(corner + "/error_mm", 1e3 * row.error);
    }
  }
}

std::vector<MeasuredCorner> corners_of(const Evaluation& evaluation) {
  std::vector<MeasuredCorner> corners;
  for (std::size_t i = 0; i < evaluation.placements.size(); ++i) {
    const SheetPlacement& placement = evaluation.placements[i];
    const Sheet& sheet = evaluation.sheets[std::size_t(placement.sheet)];
    for (const Landing& landing : placement.landings)
      corners.push_back({sheet.name, int(i) + 1, placement.distance, sheet.incidence_deg, landing.corner,
                         landing.physical, landing.projected});
  }
  return corners;
}

ExitCode evaluate(const Flags& flags, Console& console) {
  for (const std::string& file : {flags.report, flags.corners})
    if (!file.empty()) io::require_writable(file);
  Diagnostics diagnostics;
  const Outcome outcome = !flags.measured.empty() ? evaluate_measured(flags)
                          : flags.original        ? reproduce_original(flags, console)
                                                  : simulate_trial(flags, console, diagnostics);
  for (const SheetEvaluation& one : outcome.evaluation.results) say(one, console);
  for (const std::string& line : outcome.verdict) console.say(line);
  summarize(outcome.evaluation, console.summary());
  console.summary().set("/verdict", outcome.verdict);
  console.report(diagnostics);
  if (!flags.corners.empty()) {
    io::write_file_atomically(flags.corners, format_measured_corners(corners_of(outcome.evaluation), 0.01));
    console.say("wrote " + flags.corners);
  }
  if (!flags.report.empty()) {
    io::write_file_atomically(
        flags.report,
        evaluation_report(outcome.evaluation, "Where the corners of a sheet land", outcome.verdict));
    console.say("wrote " + flags.report);
  }
  return exit_code(diagnostics);
}

}  // namespace
}  // namespace procam::section_v

int main(int argc, char** argv) {
  using namespace procam::section_v;
  Flags flags;
  return procam::tools::run_tool(
      argc, argv,
      {"section_v",
       "Computes the error of the corners of a sheet of paper that are projected onto it, at 47 and 60 degrees "
       "and 1.2 to 2.2 m: simulated from a calibration and the truth, or measured with a ruler."},
      [&](CLI::App& app) { declare(app, flags); },
      [&](Console& console) { return evaluate(flags, console); });
}
