#pragma once
/// The rig in the room: the devices' places and a pose file, in one tree of frames.
#include "procam/core/geometry/frame_tree.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam::tools {

/// Frames "rig", every device's name and "world". The pose file may place the world under "projector" (the
/// one asked for), the rig or any device, in either direction.
FrameTree room_frames(const Rig& rig, const RigProjector& projector, FrameTree::Link pose);

}  // namespace procam::tools
