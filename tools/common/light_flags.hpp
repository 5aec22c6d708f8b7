#pragma once
/// What was projected, for tools that read captures of structured light on a room.
#include "procam/session/reader.hpp"

namespace CLI {
class App;
}

namespace procam::tools {

/// --pattern, --projector-size, --step. A board is not needed.
void declare_light(CLI::App& app, session::OpenOptions& open);

}  // namespace procam::tools
