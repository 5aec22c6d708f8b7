#pragma once
/// Angles of a pan-tilt head: from the network, from a log, and as poses.
///
///   {"stamp": 1700000000.25, "sequence": 7, "pan_deg": 12.5, "tilt_deg": -3.0}
///
/// A JSON line a message; degrees, as the head reports them. A log has the first line
///   {"format":"procam-angle-log","version":1}
/// and may have "arrival" besides. As poses they are predicted, checked and lost like those of a localiser:
///   world_from_tilt = world_from_head * head_from_tilt(axes, pan, tilt)
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/rig/pan_tilt.hpp"
#include "procam/track/pose_source.hpp"

namespace procam::track {

struct StampedAngles {
  std::optional<double> stamp;            ///< head's clock, seconds
  double arrival = 0;                     ///< local steady clock, seconds
  double pan = 0, tilt = 0;               ///< radians
  std::optional<std::uint32_t> sequence;  ///< counts the sender's messages by one, wraps at 2^32
};

struct ParsedAngles {
  std::vector<StampedAngles> angles;
  std::uint64_t malformed = 0;
  std::string why;  ///< of the last malformed one
};

/// Any bytes: what is no message is counted with its reason. An angle is finite and at most 100 turns.
PROCAM_EXPORT ParsedAngles parse_angles(std::string_view lines);
PROCAM_EXPORT std::string angles_to_json_line(const StampedAngles& angles);

/// Throws Error(kIo), Error(kInput) with the line. A last line that was cut is skipped.
PROCAM_EXPORT std::vector<StampedAngles> read_angle_log(const std::filesystem::path& path);
/// Throws Error(kIo).
PROCAM_EXPORT void write_angle_log(const std::filesystem::path& path,
                                   const std::vector<StampedAngles>& angles);

/// A head that stands in the world.
struct PlacedHead {
  PanTiltAxes axes;
  Pose world_from_head;
  std::string frame = "world", child = "tilt";  ///< of the poses
};
PROCAM_EXPORT StampedPose pose_of(const StampedAngles& angles, const PlacedHead& head);

/// Poses of the tilting part by the angles that arrive: udp:[ADDRESS:]PORT, tcp:HOST:PORT, tcp-listen:[ADDRESS:]PORT or
/// log:FILE[@SPEED]. Errors as of open_pose_source().
PROCAM_EXPORT std::unique_ptr<PoseSource> open_head_source(const std::string& text, const PlacedHead& head,
                                                           const SourceOptions& options = {});

/// The poses of another source, moved into another world: world_from_frame * frame_from_child.
PROCAM_EXPORT std::unique_ptr<PoseSource> moved_source(std::unique_ptr<PoseSource> source,
                                                       const Pose& world_from_frame);

}  // namespace procam::track
