#pragma once
/// The local clock of every arrival, capture and frame.
#include <chrono>

namespace procam {

/// Seconds of std::chrono::steady_clock: never set back, the same in all processes of a machine, without
/// relation to the date.
inline double steady_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace procam
