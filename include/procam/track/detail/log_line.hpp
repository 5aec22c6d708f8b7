#pragma once
/// The line of a pose in a log: {"arrival":812.25,"stamp":...}.
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string>

#include "procam/track/wire.hpp"

namespace procam::track::internal {

/// nullopt for what is no such line.
inline std::optional<StampedPose> pose_of_log_line(const std::string& line) {
  constexpr const char* kBegin = "{\"arrival\":";
  if (line.compare(0, std::strlen(kBegin), kBegin) != 0) return std::nullopt;
  const char* number = line.c_str() + std::strlen(kBegin);
  char* end = nullptr;
  const double arrival = std::strtod(number, &end);
  if (end == number || *end != ',' || !std::isfinite(arrival)) return std::nullopt;
  Parsed parsed = parse_poses("{" + std::string(end + 1));
  if (parsed.poses.size() != 1 || parsed.malformed != 0) return std::nullopt;
  parsed.poses[0].arrival = arrival;
  return std::move(parsed.poses[0]);
}

}  // namespace procam::track::internal
