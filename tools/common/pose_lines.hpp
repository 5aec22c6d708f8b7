#pragma once
/// A pose with its covariance on the console and in the summary.
#include <string>

#include "common/cli.hpp"
#include "procam/core/geometry/frame_tree.hpp"

namespace procam::tools {

/// Two lines: rotation vector and translation, each with its standard deviations; the same in the summary at `at`. The
/// sigma of the translation is that of the source's origin in the target, which differs from that of a left increment's
/// translation.
void say_link(Console& console, const FrameTree::Link& link, const std::string& at);

}  // namespace procam::tools
