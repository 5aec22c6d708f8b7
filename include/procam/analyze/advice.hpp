#pragma once
/// What is wrong with each view, and which view to add next to reduce the projection error most.
#include <optional>
#include <string>
#include <vector>

#include "procam/analyze/light_error.hpp"
#include "procam/calibrate/result.hpp"
#include "procam/core/base/export.hpp"

namespace procam::analyze {

/// Where to hold the board next.
struct NextView {
  Pose rig_from_board;
  double board_distance = 0;  ///< metres from the rig's origin to the board's middle
  std::string words;  ///< "0.90 m away, in the lower left of projector's frame, tilted 35 degrees ..."
  LightErrors now;    ///< predicted, as things are
  LightErrors then;   ///< predicted, with that view
};

/// Of some four hundred poses (five distances from 0.7 times the nearest so far to 1.3 times the farthest,
/// nine positions in the projector's frame, untilted and tilted 35 degrees in eight directions) that all
/// devices can use, the one with the smallest predicted error of the given kind on a wall at `wall` metres
/// (calibrate/next_view.hpp). nullopt when none can be used or none reduces the error.
PROCAM_EXPORT std::optional<NextView> advise_next_view(const calibrate::CalibrationResult& result,
                                                       double wall, const std::string& projector = "",
                                                       SurfaceLocated located = SurfaceLocated::kExternally);

/// A line a view: "fine", or what is wrong with it: few points, all points near the image centre, parallel to
/// another view, contributes little.
PROCAM_EXPORT std::vector<std::string> view_verdicts(const calibrate::CalibrationResult& result);

}  // namespace procam::analyze
