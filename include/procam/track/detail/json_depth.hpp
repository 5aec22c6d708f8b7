#pragma once
/// A check of untrusted JSON before a tree is built from it.
#include <string_view>

#include "procam/core/base/export.hpp"

namespace procam::track::internal {

/// Whether the brackets outside of strings are nested at most `deepest` levels.
PROCAM_EXPORT bool is_shallow(std::string_view text, int deepest);

}  // namespace procam::track::internal
