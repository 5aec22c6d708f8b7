#pragma once
/// The time that a provenance states.
#include <ctime>
#include <string>

namespace procam::tools {

/// ISO 8601, UTC, whole seconds: "2026-01-02T03:04:05Z".
inline std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

}  // namespace procam::tools
