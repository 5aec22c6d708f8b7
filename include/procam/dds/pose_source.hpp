#pragma once
/// Poses from the ROS 2 graph, without ROS: Cyclone DDS speaks to the same nodes (docs/ros2.md).
///
///   const auto source = dds::open_pose_source("ros2:map,base_link");   // or any text of track::open_pose_source()
///
/// | text | what |
/// |---|---|
/// | ros2:, ros2:map,base_link | a chain of frames from /tf and /tf_static, at the latest time at which all of it is known |
/// | ros2:/TOPIC | Odometry, PoseWithCovarianceStamped, PoseStamped or TransformStamped: the type that is published |
/// | log:FILE[+FRAME,CHILD or +/TOPIC][@SPEED] | the same from a log: MCAP, .db3 of rosbag2, or a folder of these |
/// | ...,FROM:=TO | a remap as in ROS 2: ros2:map,base_link,/tf:=/robot1/tf,/tf_static:=/robot1/tf_static |
/// | ...,use_sim_time:=true | stamps are those of /clock: at any rate, through pauses and jumps |
/// | ...,__ns:=/robot1 | a namespace for relative names |
///
/// The domain is ROS_DOMAIN_ID or 0; ROS_LOCALHOST_ONLY, ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST and CYCLONEDDS_URI are
/// respected. The pose of a chain is interpolated between stamps and never extrapolated. Its stamp is that of the senders,
/// which in one ROS graph share a clock; the track that the poses go to estimates this clock (track/clock.hpp).
///
/// What is no message is counted by its cause (PoseSource::rejected()): ros2_oversized, ros2_invalid_text,
/// ros2_invalid_pose, ros2_invalid_stamp, ros2_undecodable, ros2_foreign_type, ros2_loop, ros2_frames; log_damaged for a part of a log.
#include <memory>
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/track/pose_source.hpp"

namespace procam::dds {

/// Was procam built with Cyclone DDS?
PROCAM_EXPORT bool is_available();

/// Every kind of track::open_pose_source(), ros2:, and logs of ROS 2. Throws what that throws; Error(kUnsupported) for ros2:
/// and logs of ROS 2 in a build without DDS, and Error(kDevice) where DDS finds no network.
PROCAM_EXPORT std::unique_ptr<track::PoseSource> open_pose_source(const std::string& text,
                                                                  const track::SourceOptions& options = {});

}  // namespace procam::dds
