#pragma once
/// A verification for people: as JSON, as lines, as a picture.
#include <string>
#include <vector>

#include "procam/analyze/verify.hpp"
#include "procam/core/base/export.hpp"

namespace procam::report {

/// The result's fields as JSON text, every mark included.
PROCAM_EXPORT std::string to_json(const analyze::VerifyResult& result);

/// The lines of a console: verdict, movements, a table of the marks.
PROCAM_EXPORT std::vector<std::string> lines(const analyze::VerifyResult& result);

/// "projector turned by 0.210 +- 0.004 deg and shifted by ..."
PROCAM_EXPORT std::string description(const analyze::Movement& movement);

/// The surface as its content is read, with every mark's error as an arrow, magnified, before (and after,
/// when something was corrected), and the 95 % region in which an error would be no surprise. `content` is
/// the outline of what is shown there, on the surface; it may be empty. A complete SVG file.
PROCAM_EXPORT std::string verify_picture(const analyze::VerifyResult& result, const Points2& content = {});

}  // namespace procam::report
