#pragma once
/// The body of room_frames.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include <utility>

#include "procam/core/rig/room_frames.hpp"

namespace procam {

PROCAM_CORE_INLINE FrameTree room_frames(const Rig& rig, const RigProjector& projector,
                                         FrameTree::Link pose) {
  if (pose.target == "world") {
    pose.target_from_source = inverse(pose.target_from_source);
    std::swap(pose.target, pose.source);
  }
  if (pose.target == "projector") pose.target = projector.name;
  FrameTree frames;
  for (const RigCamera& camera : rig.cameras) frames.set("rig", camera.name, camera.rig_from_camera);
  for (const RigProjector& other : rig.projectors) frames.set("rig", other.name, other.rig_from_projector);
  frames.set(pose.target, pose.source, pose.target_from_source);
  return frames;
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
