#pragma once
/// Remarks for people: one line per kind instead of one per view.
#include <string>
#include <vector>

#include "procam/core/base/error.hpp"

namespace procam::tools {

/// As in --json and before a line.
const char* to_string(Severity severity);

/// The lines to print of all remarks, in their order. Failures stay as they are. Three or more notes, or
/// warnings of views (which are all named), of one code whose texts differ only in numbers and in the leading
/// "view ...: " become one line with their number and the median of each number,
///
///   note: 30 views: decoded row codes 2..763 of 0..767 (medians); far from them: view 'a', projector:
///   decoded row codes 300..412 of 0..767
///
/// at the position of the first. A note is far from the medians when one of its numbers differs by more than
/// five times the median deviation of that number, and by more than a tenth of the largest number in the
/// medians (2 and 3 "of 63 points" are alike).
std::vector<std::string> lines_for_people(const Diagnostics& diagnostics);

}  // namespace procam::tools
