#pragma once
/// A drive that calibrates a mount: the localiser's poses of a robot and the sightings of markers by its rig, in time,
/// with the truth. Numbers alone, no images.
///
///   const MountDrive made = mount_drive(random_walk(0.5, 60, 7), options);
///   made.base;                 // frame "map", child "base": late stamps, noise, jumps
///   made.sightings.messages;   // frame "marker_3", child "rig": marker_from_rig with covariance
///
/// A sighting is the pose that fits the four corners of the marker, projected through the camera's lens with noise of
/// corner_sigma_px on each coordinate; its covariance is sigma^2 (J^T J)^-1 there. Planes are "plane_floor" and
/// "plane_1" to "plane_4", the walls of a room 1.5 m beyond the drive. The sensor sees a plane by rays within 25 degrees of its
/// axis, 0.4 to 5 m away. The markers are placed along the
/// drive, 1.2 to 3 m before the camera and 15 to 40 degrees off the line of sight, so that any path sees some.
#include <cstdint>
#include <optional>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/board/marker.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/simulate/drive.hpp"
#include "procam/simulate/room.hpp"
#include "procam/track/stamped_pose.hpp"

namespace procam::simulate {

/// What the rig sees.
enum class SightingKind {
  kMarkers,
  kPlanes,  ///< floor and walls of a room about the drive, as a depth sensor measures them
  kBoth
};

struct SightingOptions {
  SightingKind kind = SightingKind::kMarkers;
  double sighting_rate = 10;        ///< images a second
  std::vector<double> image_times;  ///< instead: since the start, seconds
  double corner_sigma_px = 0.1;
  int markers = 8;
  double marker_size = 0.16;  ///< metres
  /// Of a plane: its tilt, and its distance in the middle of what is seen. Metres, radians.
  double plane_sigma = 0.002, plane_tilt_sigma = 0.1 * kDegree;
  double outliers = 0;  ///< share of the sightings that is wrong by up to 0.3 m, 20 degrees
  double floor_sigma = 0, floor_tilt_sigma = 0;  ///< of an uneven floor, metres and radians; slow
  /// From this time on (seconds since the start) the rig is moved on its base: base_from_rig = bump * before.
  std::optional<double> bump_time;
  Pose bump = Pose(so3_exp(Vec3(0.01, 0.02, -0.015)), Vec3(0.004, -0.006, 0.003));
  std::optional<Pose> base_from_rig;  ///< else drawn by the seed
  std::optional<Camera> camera;       ///< else 1280 x 960, 1150 px
  std::uint64_t seed = 0;
};

/// The true pose at a time of the drive.
struct TimedPose {
  double time = 0;
  Pose pose;
};

struct MarkerSightings {
  /// Stamps are times of the drive; frame "marker_3", child "rig", with covariance.
  std::vector<track::StampedPose> messages;
  Pose base_from_rig, base_from_rig_at_start;  ///< different after a bump
  std::vector<PlacedMarker> markers;           ///< world_from_marker; messages name them "marker_ID"
  std::vector<Pose> planes;                    ///< world_from_plane: the floor, then the walls
  std::vector<std::size_t> outliers;           ///< indices of messages
  std::vector<TimedPose> rig;                  ///< world_from_rig at the times of the images
};

/// Throws std::invalid_argument for numbers out of range, Error(kNotEnoughData) if no marker is seen.
PROCAM_EXPORT MarkerSightings marker_sightings(const Drive& drive, const SightingOptions& options = {});

/// The floor, walls and ceiling about a drive past planes, and a cupboard and a chest before each wall:
///   depth_view(drive_room(seen, 7), sensor, seen.rig[i].pose, seed)       // what a depth sensor on the rig measures
/// Throws std::invalid_argument for sightings of markers alone.
PROCAM_EXPORT Room drive_room(const MarkerSightings& seen, std::uint64_t seed = 0);

/// The localiser besides.
struct MountDriveOptions : SightingOptions {
  double rate = 20;                       ///< messages a second
  std::vector<double> pose_times;         ///< instead: since the start, seconds
  double position_sigma = 0.01;           ///< metres, each axis of the world
  double rotation_sigma = 0.5 * kDegree;  ///< about each axis of the base
  double correlation_s = 0;               ///< time constant of these errors (first-order); 0: white
  bool planar_localiser = true;           ///< reports height, roll and pitch of a planar robot as zero
  double latency = 0.08;                  ///< by which its stamps are late, seconds
  /// From this time on (seconds since the start) its poses are moved, about the robot: a jump on its map, or wheel
  /// slip.
  std::optional<double> jump_time;
  Pose jump = Pose(so3_exp(Vec3(0, 0, 0.06)), Vec3(0.15, -0.08, 0));
};

struct MountDrive {
  std::vector<track::StampedPose> base;  ///< in the order of their stamps
  MarkerSightings sightings;
  double time_offset = 0;  ///< localiser stamp less camera stamp of one moment
};

/// Errors as above.
PROCAM_EXPORT MountDrive mount_drive(const Drive& drive, const MountDriveOptions& options = {});

}  // namespace procam::simulate
