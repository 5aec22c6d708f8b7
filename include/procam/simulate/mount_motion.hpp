#pragma once
/// Motions that calibrate a rig on an arm or on a pan-tilt head, with the truth. Numbers alone, no images.
///
///   const ArmMotion arm = arm_motion(options);
///   mount_drive(arm.drive, arm_options(7));   // frame "map" is the arm's base, child "base" its flange
///   const HeadRun head = head_run(HeadRunOptions());
#include <cstdint>
#include <optional>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/rig/mount_data.hpp"
#include "procam/core/rig/pan_tilt.hpp"
#include "procam/simulate/mount_drive.hpp"

namespace procam::simulate {

struct ArmMotionOptions {
  double duration = 60;        ///< seconds at least
  int axes = 3;                ///< about which the flange turns: 3, 1 (a fixed one) or 0 (it only moves)
  double turn = 30 * kDegree;  ///< from the middle, at most, about each axis
  double reach = 0.15;         ///< from the middle, at most, along each axis; metres
  double speed = 0.25, turn_speed = 0.6;  ///< at most, m/s and rad/s
  std::uint64_t seed = 0;
};

struct ArmMotion {
  Drive drive;                ///< base_from_flange
  std::vector<double> rests;  ///< times since the start at which it stands still, seconds
};

/// From random pose to random pose at rest, about (0.5, 0, 0.6) m with the flange's z axis ahead (x of the arm's base).
/// Throws std::invalid_argument for numbers out of range.
PROCAM_EXPORT ArmMotion arm_motion(const ArmMotionOptions& options = {});

/// An arm's poses and its rig: 0.2 mm and 0.02 degrees of noise, 40 ms late; flange_from_rig drawn by the seed.
PROCAM_EXPORT MountDriveOptions arm_options(std::uint64_t seed);

/// Where an arm's base, or a head, stands in the room.
PROCAM_EXPORT Pose world_from_carrier(std::uint64_t seed);

struct HeadRunOptions : SightingOptions {
  double duration = 60;                ///< seconds at least
  double rate = 20;                    ///< angles a second
  double latency = 0.04;               ///< by which their stamps are late, seconds
  double angle_step = 0.05 * kDegree;  ///< quantisation
  double angle_sigma = 0.01 * kDegree;
  double runout = 0.00002;  ///< of the axes: radians, metres; each direction, white
  double pan_range = 60 * kDegree, tilt_range = 25 * kDegree;  ///< to each side; 0: it stands still
  double turn_speed = 0.5;                                     ///< at most, rad/s
  bool stations = false;            ///< angles and images only where it stands still
  std::optional<double> slip_time;  ///< from this time on the pan angles are wrong by `slip`
  double slip = 2 * kDegree;
};

struct HeadRun {
  std::vector<HeadAngles> angles;  ///< as reported: with zero errors of up to 5 degrees, quantised
  /// base_from_rig is tilt_from_rig by the reported zero; markers are in the head's frame.
  MarkerSightings sightings;
  PanTiltAxes axes;
  double time_offset = 0;
};

/// A head that turns from random angles to random angles at rest. Throws as marker_sightings().
PROCAM_EXPORT HeadRun head_run(const HeadRunOptions& options = {});

}  // namespace procam::simulate
