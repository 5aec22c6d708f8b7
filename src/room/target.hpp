#pragma once
/// The size of a target by the camera positions that see it.
#include <optional>

#include "adjust.hpp"
#include "procam/room/calibrate_room.hpp"

namespace procam::room {

/// Root of the sum of squared distances from the mean.
double extent(const Points3& points);

/// A target's points that two positions or more see, triangulated in the state's own length.
struct SeenTarget {
  Points3 places, points;  ///< in the target's frame, and in the rig's
  double rms_px = 0;       ///< of what the rays leave
};

/// X = argmin sum |(I - d d^T)(X - o)|^2 over the rays (o, d) of each point. nullopt for fewer than two such points.
/// Throws Error(kInput) for a camera or view that the session does not have.
std::optional<SeenTarget> see_target(const RoomPoints& points, const RoomState& state,
                                     const KnownTarget& target);

/// Variance of log(extent) by the pixels' noise and of the target's own size.
double size_variance(const RoomPoints& points, const RoomState& state, const KnownTarget& target);

}  // namespace procam::room
