#pragma once
/// What is wrong with each view, and which view to add next to shrink the light's error most.
#include <optional>
#include <string>
#include <vector>

#include "procam/analyze/light_error.hpp"
#include "procam/calibrate/result.hpp"

namespace procam::analyze {

/// Where to hold the board next.
struct NextView {
  Pose rig_from_board;
  double board_distance = 0;  ///< metres from the rig's origin to the board's middle
  std::string words;  ///< "0.90 m away, in the lower left of projector's picture, tilted 35 degrees ..."
  LightError now;     ///< predicted, as things are
  LightError then;    ///< predicted, with that view
};

/// Of some four hundred places (five distances from 0.7 times the nearest so far to 1.3 times the farthest,
/// nine places in the projector's picture, untilted and tilted 35 degrees in eight directions) that all
/// devices can use, the one after which the light on a wall at `wall` metres is predicted best
/// (calibrate/next_view.hpp). nullopt when none can be used or none makes it better.
std::optional<NextView> advise_next_view(const calibrate::CalibrationResult& result, double wall,
                                         const std::string& projector = "");

/// A line a view: "fine", or what is wrong with it: left out, few points, all amid the picture, parallel to
/// another view, adds little.
std::vector<std::string> view_verdicts(const calibrate::CalibrationResult& result);

}  // namespace procam::analyze
