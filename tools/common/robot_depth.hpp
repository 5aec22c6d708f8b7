#pragma once
/// The depth images that simulate-robot writes.
#include <functional>
#include <string>

#include "common/cli.hpp"
#include "procam/simulate/mount_drive.hpp"

namespace procam::tools {

/// Five a second until `end`, each called after `stamp_of` its time, in nanoseconds. The folder has to be new or empty.
void save_depth_images(const std::string& folder, const simulate::MarkerSightings& seen, std::uint64_t seed,
                       double end, const std::function<double(double)>& stamp_of, Console& console);

}  // namespace procam::tools
