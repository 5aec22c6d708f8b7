#pragma once
/// The flags of simulate-robot, and the drive that they describe.
#include <string>

#include "procam/simulate/mount_drive.hpp"
#include "procam/simulate/robot.hpp"

namespace CLI {
class App;
}

namespace procam::tools {

struct RobotFlags {
  std::string path = "circle:0.95m", to, log, truth, sightings, depth, light, true_mount, true_markers;
  bool binary = false, without_stamp = false;
  double speed = 0.5;
  simulate::RobotOptions robot;
  simulate::SightingKind see = simulate::SightingKind::kMarkers;
  double clock_offset = 0, clock_drift_ppm = 0;
};

void declare(CLI::App& app, RobotFlags& flags);

/// "arm" and "head" are no robots that drive: their motion comes with the sightings.
bool is_arm(const RobotFlags& flags);
bool is_head(const RobotFlags& flags);

/// Throws Error(kInput) for a path that is not known or cannot be read.
simulate::Drive robot_drive(const RobotFlags& flags);

}  // namespace procam::tools
