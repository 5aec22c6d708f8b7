#pragma once
/// What a camera image tells of the rig's place, for track::PoseCorrection.
#include <optional>

#include "procam/core/base/image.hpp"
#include "procam/core/board/marker.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/track/pose_correction.hpp"

namespace procam::show {

/// From the markers of the map among those in an image. Of two similar poses it is the one nearer to `expected`. nullopt: no marker of the
/// map is seen, or they contradict each other.
std::optional<track::PoseSight> sight_of_markers(const MarkerDetections& found, double time,
                                                 const RigCamera& camera, const MarkerMap& map,
                                                 const Pose& expected_world_from_rig);

}  // namespace procam::show
