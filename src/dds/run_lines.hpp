#pragma once
/// std_msgs/msg/String, whose lines make a recorded run.
#include <cstdint>
#include <string>
#include <string_view>

#include "procam/core/base/bytes.hpp"
#include "refusal.hpp"

namespace procam::dds::internal {

inline constexpr const char* kRunTopic = "/procam/run";
inline constexpr const char* kTextType = "std_msgs/msg/String";

/// CDR of a text: the header, its length with the zero at its end, and it.
inline std::string text_message(const std::string& text) {
  std::string bytes("\0\1\0\0", 4);
  const auto size = std::uint32_t(text.size() + 1);
  for (int i = 0; i < 4; ++i) bytes += char(size >> (8 * i) & 0xff);
  return bytes + text + '\0';
}

/// Throws Refusal (ros2_undecodable).
inline std::string text_of_message(std::string_view bytes) {
  ByteReader in{bytes};
  const std::string_view header = in.take(4);
  const auto size = in.number<std::uint32_t>();
  const std::string_view text = in.take(size);
  if (in.bad || header[0] != 0 || header[1] != 1 || text.empty() || text.back() != '\0')
    throw Refusal{"ros2_undecodable", "a line of the run is no text"};
  return std::string(text.substr(0, text.size() - 1));
}

}  // namespace procam::dds::internal
