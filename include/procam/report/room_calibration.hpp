#pragma once
/// The result of calibrate-room for people: as JSON, as lines, as a picture.
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/room/calibrate_room.hpp"
#include "procam/room/deviations.hpp"

namespace procam::report {

/// A rig by a room's light, with what is known of its truth.
struct RoomReport {
  room::RoomCalibration result;
  std::vector<room::ParameterDeviation> deviations = {};  ///< from a true rig; none: unknown
  double seconds = 0;                                     ///< of solving
};

PROCAM_EXPORT std::string to_json(const RoomReport& report);
PROCAM_EXPORT std::vector<std::string> lines(const RoomReport& report);

/// The room from above and from the side: its points in the colours of their standard deviation, cameras and projectors. RGB.
PROCAM_EXPORT ImageU8 room_calibration_picture(const room::RoomCalibration& result);

}  // namespace procam::report
