#pragma once
/// Trajectories that other programs wrote: a pose a line, frame_from_child.
///
/// | format | how it is recognised | a line | time | quaternion |
/// |---|---|---|---|---|
/// | TUM | 8 numbers between blanks | t x y z qx qy qz qw | s; ns above 1e14 (ORB-SLAM3) | x y z w |
/// | EuRoC ASL | "#timestamp ..., q_RS_w ..." | columns as the header names them | ns | w x y z |
/// | KITTI | 12 numbers between blanks | rows of [R|t] | none: a second file, below | none |
/// | rosbag | "%time,field. ..." (`rostopic echo -p`), "Time,header. ..." (bagpy) | columns as named | ns, s
/// | x y z w |
///
/// '#' begins a comment in TUM and KITTI files. Numbers between commas without a header are refused: EuRoC's
/// w comes first, TUM's last, and a wrong order gives rotations that look right. KITTI states no times; its
/// sequences hold them in times.txt, seconds, a line for each pose: "poses/00.txt+sequences/00/times.txt".
#include <filesystem>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/track/stamped_pose.hpp"

namespace procam::track {

struct Trajectory {
  std::string format;  ///< "TUM", "EuRoC", "KITTI", "rosbag"
  /// Stamps increase; arrival is the stamp. Frames are "map" and "base" where the file names none.
  std::vector<StampedPose> poses;
};

/// `file`: a path, or of KITTI "poses+times". Throws Error(kIo), Error(kInput) with the line,
/// Error(kNotEnoughData) for a file without poses.
PROCAM_EXPORT Trajectory read_trajectory(const std::string& file);

/// Waypoints in a plane: lines of "time x y yaw_deg" between blanks or commas, seconds and metres; '#' begins a
/// comment. Errors as above.
PROCAM_EXPORT Trajectory read_waypoints(const std::string& file);

}  // namespace procam::track
