#pragma once
#include <string>

namespace procam::dds::internal {

/// Thrown for a message that is not taken: the cause as a name ("ros2_oversized"), and a sentence.
struct Refusal {
  const char* cause;
  std::string why;
};

}  // namespace procam::dds::internal
