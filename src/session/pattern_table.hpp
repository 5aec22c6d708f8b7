#pragma once
/// The table of patterns.
#include "procam/session/patterns.hpp"

namespace procam::session {

/// A row of the table.
struct PatternRow {
  const char* name;   ///< the text before a first colon
  const char* about;  ///< one line of help
  /// `parameters` is the text after the colon, empty for the defaults; `step` the stripes' width.
  std::unique_ptr<SessionPattern> (*make)(const std::string& parameters, ImageSize projector_size, int step);
};

const std::vector<PatternRow>& pattern_table();

}  // namespace procam::session
