#include "common/robot_depth.hpp"

#include <cmath>
#include <filesystem>

#include "procam/io/image/depth_file.hpp"
#include "procam/simulate/depth_view.hpp"

namespace procam::tools {

void save_depth_images(const std::string& folder, const simulate::MarkerSightings& seen, std::uint64_t seed,
                       double end, const std::function<double(double)>& stamp_of, Console& console) {
  namespace fs = std::filesystem;
  if (fs::exists(folder) && !fs::is_empty(folder))
    throw Error(ErrorKind::kInput, folder, "it holds files already", "give a new folder");
  fs::create_directories(folder);
  const simulate::Room room = simulate::drive_room(seen, seed);
  const simulate::DepthSensor sensor;
  const int count = int(seen.rig.size());
  int written = 0;
  for (int i = 0; i < count && seen.rig[std::size_t(i)].time <= end; i += 2, ++written) {
    const simulate::TimedPose& at = seen.rig[std::size_t(i)];
    const auto nanoseconds = static_cast<long long>(std::llround(1e9 * stamp_of(at.time)));
    io::save_depth(fs::path(folder) / (std::to_string(nanoseconds) + ".png"),
                   simulate::depth_view(room, sensor, at.pose, seed + std::uint64_t(i)).mm.view());
    console.progress("depth images", i, count);
  }
  console.say(format("%d depth images", written));
}

}  // namespace procam::tools
