#pragma once
/// Figures and tables of a result as files, for a paper or another program.
///
/// The pages of this component hold their figures as inline SVG that is coloured by the page's style sheet. figures() makes
/// each a file of its own: colours of the light theme are written into it, so that programs without CSS variables
/// (Inkscape, LaTeX, librsvg) draw it as well. calibration_tables() are the numbers behind a calibration's page, as CSV.
#include <filesystem>
#include <string>
#include <vector>

#include "procam/calibrate/result.hpp"
#include "procam/core/base/export.hpp"

namespace procam::report {

/// A file in memory: "residuals_of_camera.svg" and its content, UTF-8.
struct TextFile {
  std::string name, text;
};

/// The figures of a page that this component made, in the page's order. Each is named after its description; of equal names
/// the second ends in "_2". A text without figures gives none.
PROCAM_EXPORT std::vector<TextFile> figures(const std::string& page);

/// The numbers of a calibration, each file with a header line; '.' is the decimal point in every locale.
///
///   parameters.csv   name, value, sigma: lenses (pixels; distortion without unit) and poses (rotation vector, rad; metres)
///   covariance.csv   the rig's covariance matrix, its header and first column the parameters' names; omitted when empty
///   views.csv        view, used, rig_from_board (rotation vector, translation), each device's RMS, share of the information
///   residuals.csv    view, device, point, x, y, residual_x, residual_y (projected minus observed, pixels), used, reason
PROCAM_EXPORT std::vector<TextFile> calibration_tables(const calibrate::CalibrationResult& result);

/// Throws Error(kIo) if the folder may not be written, or if its parent does not exist, which is more often a typing error than a
/// wish. For a tool's start, before the work.
PROCAM_EXPORT void require_folder(const std::filesystem::path& folder);

/// Writes the files into the folder, which is made, with its parents, where it does not exist. Each appears complete or not at all.
/// A .csv table is also written as .npy (io::npy_of_csv()). Throws Error(kIo), and Error(kInput) for a .csv that is no table.
PROCAM_EXPORT void save_files(const std::filesystem::path& folder, const std::vector<TextFile>& files);

}  // namespace procam::report
