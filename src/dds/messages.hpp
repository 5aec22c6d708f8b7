#pragma once
/// What all messages of the graph have.
#include "dds/dds.h"
#include "refusal.hpp"
#include "ros2_messages.h"

namespace procam::dds::internal {

/// The stamp of a message, seconds of the sender's clock. A stamp of zero is none: then the moment at which the message was
/// written, by the same clock. Throws Refusal (ros2_invalid_stamp).
inline double stamp_of(const builtin_interfaces_msg_dds__Time_& time, const dds_sample_info_t& info) {
  if (time.nanosec >= 1'000'000'000)
    throw Refusal{"ros2_invalid_stamp", "its stamp has more than 1e9 nanoseconds"};
  if (time.sec == 0 && time.nanosec == 0) return 1e-9 * double(info.source_timestamp);
  return time.sec + 1e-9 * time.nanosec;
}

}  // namespace procam::dds::internal
