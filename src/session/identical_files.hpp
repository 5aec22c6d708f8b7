#pragma once
/// The same file given twice.
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam::session {

/// A warning "identical_files" for every pair of folders (or of files that lie in none) that share contents
/// by their SHA-256. Two photographs are never identical: a view was copied, or saved under two names.
void warn_of_identical_files(const std::vector<InputFile>& inputs, Diagnostics& diagnostics);

}  // namespace procam::session
