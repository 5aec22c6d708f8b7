#pragma once
/// A verification for people: as JSON, as lines, as a picture.
#include <string>
#include <vector>

#include "procam/analyze/verify.hpp"
#include "procam/core/base/export.hpp"
#include "procam/report/files.hpp"

namespace procam::report {

/// The result's fields as JSON text, every mark included.
PROCAM_EXPORT std::string to_json(const analyze::VerifyResult& result);

/// The lines of a console: the verdict, the two possible causes with their odds, the error after the correction, the noise.
PROCAM_EXPORT std::vector<std::string> lines(const analyze::VerifyResult& result);

/// "projector rotated by 0.210 +- 0.0040 deg and translated by ..."
PROCAM_EXPORT std::string description(const analyze::Movement& movement);

/// marks.csv: of each mark its pixels, its intended point and error on the surface (mm), sigma, chi-square (two degrees of
/// freedom), whether it was used, and why not.
PROCAM_EXPORT std::vector<TextFile> verify_tables(const analyze::VerifyResult& result);

/// The surface as its content is read, with every mark's error as an arrow, magnified, before (and after,
/// when something was corrected), and the 95 % region in which an error would be no surprise. `content` is
/// the outline of what is shown there, on the surface; it may be empty. A complete SVG file.
PROCAM_EXPORT std::string verify_picture(const analyze::VerifyResult& result, const Points2& content = {});

}  // namespace procam::report
