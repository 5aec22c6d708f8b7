#pragma once
/// The images that simulate-robot writes: of a depth sensor on the robot, and of a rig's camera in the light of its projector.
#include <functional>
#include <string>

#include "common/cli.hpp"
#include "procam/simulate/mount_drive.hpp"

namespace procam::tools {

/// What the drive was, and how its images are named.
struct DriveImages {
  const simulate::MarkerSightings& seen;
  std::uint64_t seed = 0;
  double end = 0;  ///< seconds since the start
  std::function<double(double)>
      stamp_of;  ///< of a time of the drive; a file is called after it, in nanoseconds
};

/// Five a second. The folder has to be new or empty.
void save_depth_images(const std::string& folder, const DriveImages& drive, Console& console);

/// Likewise, of the board frame of the pattern "markers"; and the rig, rig.json in the same folder.
void save_light_images(const std::string& folder, const DriveImages& drive, Console& console);

}  // namespace procam::tools
