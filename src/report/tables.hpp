#pragma once
/// The words and numbers of the report, section by section.
#include <string>

#include "procam/report/calibration.hpp"

namespace procam::report {

/// Did it pass, and if not: which gate, why, and what to do.
std::string verdict(const calibrate::CalibrationResult& result, const ReportInput& input);

/// The four or five figures that most readers come for.
std::string key_figures(const calibrate::CalibrationResult& result, const ReportInput& input);

/// Lens, optics and pose of a device with their sigmas.
std::string device_numbers(const calibrate::CalibrationResult& result, const Device& device);

/// RMS, held-out error and noise by device.
std::string residual_numbers(const calibrate::CalibrationResult& result);

/// Millimetres on a wall, surface located externally and by camera; empty when the input has none.
std::string wall_errors(const ReportInput& input);

std::string gate_table(const RigQuality& quality);
/// Failures (but of quality checks, which have their own table) and warnings, then the notes, folded.
std::string diagnostic_list(const Diagnostics& diagnostics);
std::string view_table(const calibrate::CalibrationResult& result);

/// What to capture next, and what it would bring; empty when nothing is known to help.
std::string next_view(const std::optional<analyze::NextView>& next, analyze::SurfaceLocated located);
std::string provenance_section(const Provenance& provenance);

}  // namespace procam::report
