#pragma once
/// A depth sensor behind OpenNI2's own library, for programs that are started with its variables
/// (environment()) or have set them before OpenNI2 starts: tests/device/simulated_depth_driver.cpp shows what
/// is written here.
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "procam/core/base/image.hpp"

namespace procam::test {

class SimulatedSensor {
 public:
  explicit SimulatedSensor(std::filesystem::path folder) : folder_(std::move(folder)) {
    std::filesystem::create_directories(folder_);
  }
  /// Of this process.
  void announce() const { setenv("PROCAM_SIMULATED_SENSOR", folder_.c_str(), 1); }
#ifdef PROCAM_SIMULATED_OPENNI2
  /// For another: OpenNI2's library looks for drivers beside where it was found. What its unloaded drivers keep looks like
  /// a leak.
  std::string environment() const {
    return "ASAN_OPTIONS=$ASAN_OPTIONS:detect_leaks=0 LD_LIBRARY_PATH=" PROCAM_SIMULATED_OPENNI2
           " PROCAM_SIMULATED_SENSOR=" +
           folder_.string();
  }
#endif
  void plug() const {
    std::ofstream(folder_ / "plugged");
  }
  void unplug() const {
    std::filesystem::remove(folder_ / "plugged");
  }
  /// Tenths of a millimetre; the stamp by the sensor's own clock.
  void show(ImageView<const std::uint16_t> tenths, std::uint64_t stamp_us) const {
    {
      std::ofstream out(folder_ / "next", std::ios::binary);
      out << tenths.width << ' ' << tenths.height << ' ' << stamp_us << '\n';
      for (int y = 0; y < tenths.height; ++y)
        out.write(reinterpret_cast<const char*>(tenths.row(y)), 2 * tenths.width);
    }
    std::filesystem::rename(folder_ / "next", folder_ / "picture");
  }

 private:
  std::filesystem::path folder_;
};

}  // namespace procam::test
