#include "trial.hpp"

#include <cmath>
#include <map>

#include "csv.hpp"
#include "measured_corners.hpp"
#include "procam/core/base/words.hpp"
#include "procam/io/rig_file.hpp"
#include "sheet_experiment.hpp"

namespace procam::section_v {
namespace {

/// Of the system that procam succeeds: reprojection error of its calibration, and the mean errors of the corners of its two
/// sheets.
constexpr double kOriginalPixelRms = 1.54;
constexpr double kOriginalMeanMm[] = {12, 20};

std::string mm(double value) {
  return format("%.2f mm", value);
}

void require_devices(const Rig& rig, const std::filesystem::path& file) {
  if (rig.cameras.empty() || rig.projectors.empty())
    throw Error(ErrorKind::kInput, file.string(), "it has no camera or no projector",
                "give a rig with one of each");
}

/// The lens of a projector of whom nothing is known but the light's directions.
Projector nominal_projector() {
  return Projector{Camera{{1024, 768}, {1900.0, 1900.0, 511.5, 383.5, 0.0}, NoDistortion{}}};
}

}  // namespace

Outcome simulate_trial(const TrialInput& input, std::uint64_t seed, const TrialProgress& progress) {
  const Rig truth = io::load_rig(input.truth), rig = io::load_rig(input.rig);
  require_devices(truth, input.truth);
  require_devices(rig, input.rig);
  for (const auto& [a, b, what] :
       {std::tuple(rig.cameras.front().camera.size, truth.cameras.front().camera.size, "camera"),
        std::tuple(rig.projectors.front().projector.size(), truth.projectors.front().projector.size(),
                   "projector")})
    if (a != b)
      throw Error(ErrorKind::kInput, input.rig.string(),
                  "its " + std::string(what) + " has " + std::to_string(a.width) + "x" +
                      std::to_string(a.height) + " pixels, the true one " + std::to_string(b.width) + "x" +
                      std::to_string(b.height),
                  "give the truth that the rig was calibrated from");
  const std::vector<Sheet>& sheets = input.layout.sheets;
  const Projector& projector = truth.projectors.front().projector;
  const std::vector<SheetPlacement> placements = draw_placements(projector, input.layout, seed);
  const SheetExperiment experiment =
      run_sheet_experiment(placements, sheets, truth, rig, input.noise_grey, seed,
                           [&](int i) { progress(i + 1, int(placements.size())); });
  Outcome outcome{evaluate(sheets, experiment.placements, projector), {}, {}, {}, {}};
  if (experiment.unseen > 0)
    outcome.diagnostics.warn("marker_unseen",
                             std::to_string(experiment.unseen) + " of " + std::to_string(placements.size()) +
                                 " sheets carry a marker that the camera does not see well enough");
  if (rig.covariance.empty())
    outcome.diagnostics.warn("no_calibration_covariance",
                             input.rig.string() +
                                 ": it carries no covariance, nothing is predicted; calibrate with "
                                 "calibrate-projector to have one");
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
    outcome.halves.push_back({true_pose.results[i].median_mm, true_calibration.results[i].median_mm});
  }
  return outcome;
}

Outcome reproduce_original(const TrialInput& input, std::uint64_t seed, const TrialProgress& progress) {
  const Rig truth = io::load_rig(input.truth);
  require_devices(truth, input.truth);
  const std::vector<Sheet> sheets = original_sheets();
  const Projector& projector = truth.projectors.front().projector;
  std::vector<SheetPlacement> placements = draw_placements(projector, {}, seed);
  CrudeCalibration crude{kOriginalPixelRms, {}};
  for (int i = 0; i < int(sheets.size()); ++i) {
    progress(i + 1, int(sheets.size()));
    crude.turn.push_back(
        turn_explaining(placements, sheets, i, projector, crude.pixel_rms, kOriginalMeanMm[i], seed));
  }
  draw_crude_landings(placements, sheets, projector, {crude.pixel_rms, {0, 0}}, seed);
  const Evaluation pixels_alone = evaluate(sheets, placements, projector);
  draw_crude_landings(placements, sheets, projector, {0, crude.turn}, seed);
  const Evaluation turn_alone = evaluate(sheets, placements, projector);
  draw_crude_landings(placements, sheets, projector, crude, seed);
  Outcome outcome{evaluate(sheets, placements, projector), {}, {}, {}, {}};
  outcome.evaluation.rig = truth;
  outcome.verdict.push_back("The original's 12 and 20 mm are an angular bias, not its reprojection error.");
  for (std::size_t i = 0; i < outcome.evaluation.results.size(); ++i) {
    const SheetEvaluation& one = outcome.evaluation.results[i];
    const double turn_deg = crude.turn[i] / kDegree;
    outcome.verdict.push_back(format(
        "%s: %.1f mm mean. Its reprojection error of %.2f px explains %.1f mm; a common rotation of the projector by %.2f "
        "degrees explains the rest (%.1f mm alone).",
        one.sheet.name.c_str(), one.mean_mm, crude.pixel_rms, pixels_alone.results[i].mean_mm, turn_deg,
        turn_alone.results[i].mean_mm));
    outcome.shares.push_back({pixels_alone.results[i].mean_mm, turn_alone.results[i].mean_mm, turn_deg});
  }
  return outcome;
}

Outcome evaluate_measured(const std::filesystem::path& file, double unit,
                          const std::filesystem::path& rig_file) {
  const std::vector<MeasuredCorner> corners = load_measured_corners(file, unit);
  Projector projector = nominal_projector();
  if (!rig_file.empty()) {
    const Rig rig = io::load_rig(rig_file);
    require_devices(rig, rig_file);
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
  Outcome outcome{evaluate(sheets, placements, projector), {}, {}, {}, {}};
  for (const SheetEvaluation& one : outcome.evaluation.results) {
    outcome.verdict.push_back("On " + one.sheet.name + " the projected corners are " + mm(one.mean_mm) +
                              " off (mean of " + std::to_string(one.landings) + "; " + mm(one.worst_mm) +
                              " at most).");
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

std::string corners_table(const Evaluation& evaluation) {
  std::string table =
      "sheet,placement,distance_m,incidence_deg,corner,physical_x_mm,physical_y_mm,projected_x_mm,projected_y_mm\n";
  for (std::size_t i = 0; i < evaluation.placements.size(); ++i) {
    const SheetPlacement& placement = evaluation.placements[i];
    const Sheet& sheet = evaluation.sheets[std::size_t(placement.sheet)];
    for (const Landing& landing : placement.landings)
      report::add_csv_row(
          table,
          {report::csv_quoted(sheet.name), std::to_string(i + 1), report::csv_number(placement.distance),
           report::csv_number(sheet.incidence_deg), std::to_string(landing.corner + 1),
           report::csv_number(1e3 * landing.physical.x()), report::csv_number(1e3 * landing.physical.y()),
           report::csv_number(1e3 * landing.projected.x()), report::csv_number(1e3 * landing.projected.y())});
  }
  return table;
}

std::string sheets_table(const std::vector<Outcome>& trials, std::uint64_t first_seed) {
  std::string table =
      "trial,seed,sheet,incidence_deg,placements,mean_mm,median_mm,rms_mm,worst_mm,predicted_rms_mm,inside_95,"
      "with_true_pose_median_mm,with_true_calibration_median_mm\n";
  for (std::size_t t = 0; t < trials.size(); ++t)
    for (std::size_t i = 0; i < trials[t].evaluation.results.size(); ++i) {
      const SheetEvaluation& one = trials[t].evaluation.results[i];
      const bool is_predicted = one.predicted_rms_mm > 0, has_halves = i < trials[t].halves.size();
      report::add_csv_row(
          table,
          {std::to_string(t + 1), std::to_string(first_seed + t), report::csv_quoted(one.sheet.name),
           report::csv_number(one.sheet.incidence_deg), std::to_string(one.placements),
           report::csv_number(one.mean_mm), report::csv_number(one.median_mm), report::csv_number(one.rms_mm),
           report::csv_number(one.worst_mm), is_predicted ? report::csv_number(one.predicted_rms_mm) : "",
           is_predicted ? report::csv_number(one.inside_95) : "",
           has_halves ? report::csv_number(trials[t].halves[i].with_true_pose_mm) : "",
           has_halves ? report::csv_number(trials[t].halves[i].with_true_calibration_mm) : ""});
    }
  return table;
}

}  // namespace procam::section_v
