#pragma once
/// calibrate-projector --update: a rig refreshed by new views.
#include "common/projector_flags.hpp"

namespace procam::tools {

/// Reads `contents` against the rig of --update, writes the refreshed rig, and says what changed.
ExitCode update_rig(const ProjectorFlags& flags, const session::SessionContents& contents, Console& console);

}  // namespace procam::tools
