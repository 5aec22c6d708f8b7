#pragma once
/// What all messages of the graph have.
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "dds/dds.h"
#include "refusal.hpp"
#include "ros2_messages.h"

namespace procam::dds::internal {

/// The stamp of a message, seconds of the sender's clock. A stamp of zero is none: then `written`, the moment at which the
/// message was written, by the same clock. Throws Refusal (ros2_invalid_stamp).
inline double stamp_of(const builtin_interfaces_msg_dds__Time_& time, double written) {
  if (time.nanosec >= 1'000'000'000)
    throw Refusal{"ros2_invalid_stamp", "its stamp has more than 1e9 nanoseconds"};
  if (time.sec == 0 && time.nanosec == 0) return written;
  return time.sec + 1e-9 * time.nanosec;
}

/// Seconds of Unix time as ROS writes them.
inline builtin_interfaces_msg_dds__Time_ ros_time(double unix_time) {
  const double whole = std::floor(unix_time);
  return {std::int32_t(whole), std::min(std::uint32_t(1e9 * (unix_time - whole)), 999'999'999u)};
}

/// When DDS says that a sample was written, seconds.
inline double written(const dds_sample_info_t& info) {
  return 1e-9 * double(info.source_timestamp);
}

}  // namespace procam::dds::internal
