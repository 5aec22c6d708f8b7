#pragma once
/// The table of pose sources.
#include "procam/track/pose_source.hpp"

namespace procam::track {

/// One row of the table: the word before the colon, how to type it, what it is.
struct PoseSourceKind {
  const char* name;
  const char* form;
  const char* about;
  std::unique_ptr<PoseSource> (*open)(const std::string& rest, const SourceOptions& options);
};

const std::vector<PoseSourceKind>& pose_source_kinds();

}  // namespace procam::track
