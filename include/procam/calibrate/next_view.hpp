#pragma once
/// What one more view would tell, before it is captured.
///
/// With S the normal matrix of the solution over what views share and S_v that of a view at a given pose of
/// the same board, seen by the same devices with the same noise,
///   C' = (S + S_v)^-1
/// to first order: nothing of it depends on what the view's pixels will be. (V. Fedorov, "Theory of optimal
/// experiments", 1972.)
#include <optional>
#include <vector>

#include "procam/calibrate/result.hpp"
#include "procam/core/base/export.hpp"

namespace procam::calibrate {

/// The rig's covariance (the rows of result.rig.covariance) with one more view at each of the poses.
/// Where the residuals of the views exceed their noise (result.variance_ratio), the new one is assumed to
/// as well. nullopt for a pose that the session's devices could not use: no camera that sees every point
/// of the board, no projector that lights nine tenths of them (or, where the light is projected corners,
/// fewer of them on the sheet than two thirds of what a view has had so far), or seen more than 60
/// degrees from the side. All nullopt when the rig has no covariance.
PROCAM_EXPORT std::vector<std::optional<NamedCovariance>> covariance_with_view(
    const CalibrationResult& result, const std::vector<Pose>& rig_from_board);

}  // namespace procam::calibrate
