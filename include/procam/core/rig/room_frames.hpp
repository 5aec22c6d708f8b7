#pragma once
/// The rig in the room: the devices' poses and one measured pose, in one tree of frames.
#include <utility>

#include "procam/core/geometry/frame_tree.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam {

/// Frames "rig", every device's name and "world". The pose may place the world relative to "projector" (which
/// means `projector`), the rig or any device, in either direction. Throws as FrameTree::set does.
inline FrameTree room_frames(const Rig& rig, const RigProjector& projector, FrameTree::Link pose) {
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
