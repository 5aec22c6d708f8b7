#pragma once
/// The picture of a verification.
#include <string>

#include "procam/analyze/verify.hpp"

namespace procam::report {

/// The surface as its content is read, with every mark's error as an arrow, magnified, before (and after,
/// when something was corrected), and the 95 % region in which an error would be no surprise. `content` is
/// the outline of what is shown there, on the surface; it may be empty. A complete SVG file.
std::string verify_picture(const analyze::VerifyResult& result, const Points2& content = {});

}  // namespace procam::report
