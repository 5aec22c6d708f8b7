#pragma once
/// The experiment of evaluation.hpp in a simulated room: below each sheet hangs a marker, the true
/// camera takes a noisy picture of it, and the rig that is on trial says from that picture which pixels light
/// the sheet's corners. The true projector sends their light.
#include <functional>

#include "evaluation.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam::section_v {

struct SheetExperiment {
  std::vector<SheetPlacement> placements;  ///< with landings and what was promised for each
  /// The same corners if one half of the chain were perfect: what the other half explains.
  std::vector<SheetPlacement> with_true_pose, with_true_calibration;
  int unseen = 0;  ///< placements whose marker the camera did not see, or not well enough
};

/// The marker's black square, and how far its middle hangs below the sheet's edge, metres.
constexpr double kMarkerSize = 0.16, kMarkerBelow = 0.12;

/// `truth` and `rig` have the same devices; the first camera and projector are used. `noise_grey`: sigma of
/// the camera's noise, grey levels. `step` is called before each placement.
SheetExperiment run_sheet_experiment(std::vector<SheetPlacement> placements, const std::vector<Sheet>& sheets,
                                     const Rig& truth, const Rig& rig, double noise_grey, std::uint64_t seed,
                                     const std::function<void(int)>& step);

}  // namespace procam::section_v
