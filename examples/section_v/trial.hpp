#pragma once
/// The experiment's three forms: simulated with a calibration, as bad as the original's, and measured with a ruler.
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "evaluation.hpp"

namespace procam::section_v {

/// Medians of one sheet's errors if one half of the chain were perfect, mm.
struct PerfectHalves {
  double with_true_pose_mm = 0, with_true_calibration_mm = 0;
};

/// Of --original: what each part of a crude calibration does alone.
struct CrudeShares {
  double pixels_alone_mean_mm = 0, turn_alone_mean_mm = 0, turn_deg = 0;
};

struct Outcome {
  Evaluation evaluation;
  std::vector<std::string> verdict;   ///< sentences, the most important first
  std::vector<PerfectHalves> halves;  ///< of a simulated trial, one a sheet of the evaluation
  std::vector<CrudeShares> shares;    ///< of the original, likewise
  Diagnostics diagnostics;
};

/// Called before each of `all` placements or sheets.
using TrialProgress = std::function<void(int done, int all)>;

struct TrialInput {
  std::filesystem::path rig, truth;  ///< of two rigs with the same devices
  SheetLayout layout;
  double noise_grey = 2;  ///< of the simulated camera, grey levels
};

/// A simulated trial. Throws Error(kInput) for rigs of different devices.
Outcome simulate_trial(const TrialInput& input, std::uint64_t seed, const TrialProgress& progress);

/// The original's calibration: its pixel error, and the rotations that explain its means.
Outcome reproduce_original(const TrialInput& input, std::uint64_t seed, const TrialProgress& progress);

/// `file` as measured_corners.hpp reads it, lengths in `unit` metres; `rig` may be empty.
Outcome evaluate_measured(const std::filesystem::path& file, double unit, const std::filesystem::path& rig);

/// Tables of an evaluation, for --data:
///
///   corners.csv   sheet, placement, distance_m, incidence_deg, corner, and physical and projected x, y in millimetres
///   sheets.csv    one row a sheet: its errors, the prediction, and the errors with perfect halves
///   trials.csv    one row a trial and sheet; only for several trials
std::string corners_table(const Evaluation& evaluation);
std::string sheets_table(const std::vector<Outcome>& trials, std::uint64_t first_seed);

}  // namespace procam::section_v
