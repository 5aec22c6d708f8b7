#include "procam/simulate/conditions.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace procam::simulate {

int frame_at(double share, int frames) {
  if (frames < 2) return 0;
  return std::clamp(1 + int(std::floor(share * (frames - 1))), 1, frames - 1);
}

std::string description(const ViewDefects& defects, int frames) {
  std::string text;
  const auto add = [&](const char* format, auto... values) {
    char part[120];
    std::snprintf(part, sizeof part, format, values...);
    text += (text.empty() ? "" : ", ") + std::string(part);
  };
  if (defects.white) add("white at %.0f %% of full scale", 100 * *defects.white);
  if (defects.moved && frames > 1)
    add("board moved by %.1f mm before frame %d", 1e3 * defects.moved->board_from_moved.translation.norm(),
        frame_at(defects.moved->share, frames));
  if (defects.stale && frames > 1) {
    const int frame = frame_at(*defects.stale, frames);
    add("capture %d shows frame %d", frame, frame - 1);
  }
  if (defects.missing && frames > 1) add("frame %d is missing", frame_at(*defects.missing, frames));
  if (defects.torn && frames > 1) {
    const int frame = frame_at(*defects.torn, frames);
    add("capture %d shows frame %d in its lower rows", frame - 1, frame);
  }
  return text;
}

}  // namespace procam::simulate
