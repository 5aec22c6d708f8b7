#pragma once
/// The local clock of every arrival, capture and frame.
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <string>

namespace procam {

/// Seconds of std::chrono::steady_clock: never set back, the same in all processes of a machine, without
/// relation to the date.
inline double steady_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// The time that files state, in UTC, ISO 8601 with whole seconds: "2026-01-02T03:04:05Z". SOURCE_DATE_EPOCH
/// (seconds since 1970), where it is set, takes the place of the present: then equal input gives equal files
/// (https://reproducible-builds.org/specs/source-date-epoch).
inline std::string utc_now() {
  std::time_t now = std::time(nullptr);
  if (const char* epoch = std::getenv("SOURCE_DATE_EPOCH")) {
    char* end = nullptr;
    const long long seconds = std::strtoll(epoch, &end, 10);
    if (end != epoch && *end == '\0') now = std::time_t(seconds);
  }
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

}  // namespace procam
