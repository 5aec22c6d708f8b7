/// section_v: where the corners of a sheet land, simulated or measured with a ruler -> table and
/// page.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "common/cli.hpp"
#include "common/help.hpp"
#include "evaluation_page.hpp"
#include "measured_corners.hpp"
#include "procam/io/files.hpp"
#include "procam/io/text.hpp"
#include "procam/report/files.hpp"
#include "trial.hpp"

namespace procam::section_v {
namespace {

using tools::Console;
using tools::exit_code;
using tools::ExitCode;

using tools::Summary;

struct Flags {
  std::string measured, units, report, corners, figures, data;
  bool original = false;
  TrialInput input;
  std::uint64_t seed = 1;
  int trials = 1;
};

std::vector<std::string> parts_of(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  if (parts.empty()) parts.emplace_back();  // no value is none that can be read
  return parts;
}

void declare_experiment(CLI::App& app, Flags& flags) {
  SheetLayout& layout = flags.input.layout;
  tools::add_parsed(
      app, "--angles",
      [&](const std::string& text) {
        layout.sheets.clear();
        for (const std::string& one : parts_of(text)) {
          const double degrees = io::parse_angle(one) / kDegree;
          if (!(degrees >= 0 && degrees <= 80))
            throw Error(ErrorKind::kInput, "'" + one + "'", "the angle is not from 0 to 80 degrees",
                        "give angles between the light and the sheet's normal, e.g. 47deg,60deg");
          const Sheet sheet = sheet_at(std::round(1e6 * degrees) / 1e6);
          for (const Sheet& other : layout.sheets)
            if (other.name == sheet.name)
              throw Error(ErrorKind::kInput, "'" + one + "'", "the angle is given twice",
                          "give each angle once; --placements repeats a sheet");
          layout.sheets.push_back(sheet);
        }
      },
      "Angles of incidence, a sheet for each (default: 47deg,60deg)");
  tools::add_parsed(
      app, "--distances",
      [&](const std::string& text) {
        layout.distances.clear();
        for (const std::string& one : parts_of(text)) {
          layout.distances.push_back(io::parse_length(one));
          if (!(layout.distances.back() >= 0.2 && layout.distances.back() <= 50))
            throw Error(ErrorKind::kInput, "'" + one + "'", "the distance is not from 0.2 m to 50 m",
                        "give distances of the sheets from the projector, e.g. 1.2m,1.6m,2.2m");
        }
      },
      "Distances of the sheets, in turn (default: 1.2m,1.6m,2.2m)");
  app.add_option("--placements", layout.placements, "Placements of each sheet")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  app.add_option("--noise", flags.input.noise_grey, "Noise of the simulated camera, one sigma in grey levels")
      ->check(CLI::Range(0.0, 64.0))
      ->capture_default_str();
  app.add_option("--seed", flags.seed, "Of placements and noise")->capture_default_str();
  app.add_option("--trials", flags.trials,
                 "Repeat the experiment with the next seeds; page and corners are those of the first")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
}

void declare(CLI::App& app, Flags& flags) {
  auto* rig =
      app.add_option("--rig", flags.input.rig, "The rig under test, as calibrate-projector writes it");
  auto* truth =
      app.add_option("--truth", flags.input.truth,
                     "The true rig (simulate-captures writes truth.json): the experiment is simulated");
  auto* measured =
      app.add_option("--measured", flags.measured,
                     "points.csv, positions of the corners measured with a ruler: sheet, placement, "
                     "distance_m, incidence_deg, corner, physical_x, physical_y, projected_x, "
                     "projected_y");
  auto* units = app.add_option("--units", flags.units, "Unit of the positions in points.csv: mm, cm, m or in")
                    ->check(CLI::IsMember({"mm", "cm", "m", "in"}));
  auto* original =
      app.add_flag("--original", flags.original,
                   "Simulate the original paper's calibration (1.54 px RMS) and break down its 12 and "
                   "20 mm errors");
  measured->needs(units);
  units->needs(measured);
  measured->excludes(truth)->excludes(original);
  original->excludes(rig)->needs(truth);
  tools::declare_group(app, "Experiment", [&] { declare_experiment(app, flags); });
  app.add_option("--report", flags.report, "Also write a self-contained HTML page");
  app.add_option("--figures", flags.figures, "Also write the page's figures into this folder, as SVG files");
  app.add_option(
      "--data", flags.data,
      "Also write all corners and the errors of each sheet and trial into this folder, as CSV files");
  app.add_option("--corners", flags.corners,
                 "Also write every corner, as --measured --units cm reads them, .csv");
  app.callback([=, &app] {
    if (measured->count() == 0 && truth->count() == 0) throw CLI::RequiredError("--truth or --measured");
    if (truth->count() > 0 && rig->count() + original->count() == 0)
      throw CLI::RequiredError("--rig or --original");
    for (const char* name : {"--angles", "--distances", "--placements", "--trials", "--noise"})
      if ((measured->count() > 0 || original->count() > 0) && app.get_option(name)->count() > 0)
        throw CLI::ValidationError(name, "has an effect with --rig and --truth alone");
  });
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
    if (one.pose_rms_mm > 0)
      console.say(format("  %-22s %8.2f mm alone (its position and rotation are correlated)",
                         "rig pose, whole", one.pose_rms_mm));
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

/// Of --trials: the spread of each sheet's median.
void say_trials(const std::vector<Outcome>& trials, Console& console) {
  for (std::size_t i = 0; i < trials.front().evaluation.results.size(); ++i) {
    std::vector<double> medians;
    for (const Outcome& trial : trials)
      if (i < trial.evaluation.results.size()) medians.push_back(trial.evaluation.results[i].median_mm);
    std::sort(medians.begin(), medians.end());
    const std::string name = trials.front().evaluation.results[i].sheet.name;
    console.say(format("%s, %zu trials: medians %.2f to %.2f mm, half of them below %.2f mm", name.c_str(),
                       medians.size(), medians.front(), medians.back(), medians[medians.size() / 2]));
    const std::string at = "/trials/" + std::to_string(i);
    console.summary().set(at + "/name", name);
    console.summary().set(at + "/median_mm", medians);
  }
}

std::vector<Outcome> outcomes(const Flags& flags, Console& console) {
  std::vector<Outcome> all;
  if (!flags.measured.empty()) {
    all.push_back(evaluate_measured(flags.measured, io::parse_length("1" + flags.units), flags.input.rig));
  } else if (flags.original) {
    all.push_back(reproduce_original(flags.input, flags.seed,
                                     [&](int done, int total) { console.progress("sheet", done, total); }));
  } else {
    for (int t = 0; t < flags.trials; ++t)
      all.push_back(simulate_trial(flags.input, flags.seed + std::uint64_t(t), [&](int done, int total) {
        console.progress("placement", t * total + done, flags.trials * total);
      }));
  }
  return all;
}

void summarize(const Outcome& outcome, Summary& summary) {
  summarize(outcome.evaluation, summary);
  for (std::size_t i = 0; i < outcome.halves.size(); ++i) {
    const std::string at = "/sheets/" + std::to_string(i);
    summary.set(at + "/with_true_pose_median_mm", outcome.halves[i].with_true_pose_mm);
    summary.set(at + "/with_true_calibration_median_mm", outcome.halves[i].with_true_calibration_mm);
  }
  for (std::size_t i = 0; i < outcome.shares.size(); ++i) {
    const std::string at = "/sheets/" + std::to_string(i);
    summary.set(at + "/pixels_alone_mean_mm", outcome.shares[i].pixels_alone_mean_mm);
    summary.set(at + "/turn_alone_mean_mm", outcome.shares[i].turn_alone_mean_mm);
    summary.set(at + "/turn_deg", outcome.shares[i].turn_deg);
  }
  summary.set("/verdict", outcome.verdict);
}

void write_files(const Flags& flags, const std::vector<Outcome>& trials, Console& console) {
  const Outcome& outcome = trials.front();
  if (!flags.corners.empty()) {
    io::write_file_atomically(flags.corners, format_measured_corners(corners_of(outcome.evaluation), 0.01));
    console.say("wrote " + flags.corners);
  }
  if (!flags.data.empty()) {
    std::vector<report::TextFile> tables = {{"corners.csv", corners_table(outcome.evaluation)},
                                            {"sheets.csv", sheets_table({outcome}, flags.seed)}};
    if (trials.size() > 1) tables.push_back({"trials.csv", sheets_table(trials, flags.seed)});
    report::save_files(flags.data, tables);
    console.say("wrote tables into " + flags.data);
  }
  if (flags.report.empty() && flags.figures.empty()) return;
  const std::string page = evaluation_report(outcome, "Projected corners of a sheet");
  if (!flags.report.empty()) {
    io::write_file_atomically(flags.report, page);
    console.say("wrote " + flags.report);
  }
  if (!flags.figures.empty()) {
    report::save_files(flags.figures, report::figures(page));
    console.say("wrote figures into " + flags.figures);
  }
}

ExitCode evaluate(const Flags& flags, Console& console) {
  for (const std::string& file : {flags.report, flags.corners})
    if (!file.empty()) io::require_writable(file);
  for (const std::string& folder : {flags.figures, flags.data})
    if (!folder.empty()) report::require_folder(folder);
  const std::vector<Outcome> trials = outcomes(flags, console);
  const Outcome& outcome = trials.front();
  for (const SheetEvaluation& one : outcome.evaluation.results) say(one, console);
  for (const std::string& line : outcome.verdict) console.say(line);
  if (trials.size() > 1) say_trials(trials, console);
  summarize(outcome, console.summary());
  console.report(outcome.diagnostics);
  write_files(flags, trials, console);
  return exit_code(outcome.diagnostics);
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
       "and 1.2 to 2.2 m or elsewhere: simulated from a calibration and the truth, or measured with a ruler."},
      [&](CLI::App& app) { declare(app, flags); },
      [&](Console& console) { return evaluate(flags, console); });
}
