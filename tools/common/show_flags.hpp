#pragma once
/// The flags of a show: each is a field of show::ShowOptions.
#include "procam/show/show_options.hpp"

namespace CLI {
class App;
}

namespace procam::tools {

/// With --show FILE the file is read first, whatever the order, and the other flags change what it gives.
void declare_show(CLI::App& app, show::ShowOptions& options);

}  // namespace procam::tools
