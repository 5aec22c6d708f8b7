#pragma once
/// The table of depth sources.
#include "procam/device/depth_source.hpp"

namespace procam::device {

/// One row of the table.
struct DepthKind {
  const char* name;
  const char* form;
  std::unique_ptr<DepthSource> (*open)(const std::string& rest, const DepthOptions& options);
};

const std::vector<DepthKind>& depth_kinds();

}  // namespace procam::device
