#pragma once
/// The options that calibrate-projector and calibrate-camera have in common, and what follows every calibration.
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "common/cli.hpp"
#include "procam/calibrate/options.hpp"
#include "procam/core/rig/observation.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/report/calibration.hpp"

namespace procam::tools {

struct CalibrationFlags {
  std::filesystem::path observations, write_observations, output, report, figures, data;
  std::vector<Device> cameras;  ///< of a table of observations
  std::string board_shape = "auto";
  std::vector<std::string> free, fixed;
  bool holdout = false, keep_outliers = false;
};

/// --observations, --camera-size, --write-observations, -o, --report, --figures, --data,
/// --board-shape, --keep-outliers, --holdout, --fix.
void declare_calibration(CLI::App& app, CalibrationFlags& flags);

/// Throws Error(kIo) for a file of the flags that cannot be written.
void require_outputs(const CalibrationFlags& flags);

/// What the flags say of outliers, held-out views and the board's shape.
calibrate::Options calibration_options(const CalibrationFlags& flags);

/// Adds what the flags chose to a rig's provenance; `models`: the lens models, by flag.
void add_options(const CalibrationFlags& flags, const std::map<std::string, std::string>& models,
                 Provenance& provenance);

/// Writes the report page, its figures and its numbers, as far as the flags ask for them.
void write_report(const CalibrationFlags& flags, const calibrate::CalibrationResult& result,
                  const Correspondences& correspondences, const report::ReportInput& input);

/// "written    rig.json, report.html"
std::string written_line(const CalibrationFlags& flags);

}  // namespace procam::tools
