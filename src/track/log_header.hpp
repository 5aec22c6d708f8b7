#pragma once
/// The first line of a log: a JSON object that names its format and version. Spacing, the order of the keys and
/// other keys are free.
#include <string>
#include <string_view>

namespace procam::track::internal {

/// Empty, or why the line does not begin version 1 of `format`.
std::string log_header_fault(std::string_view line, std::string_view format);

}  // namespace procam::track::internal
