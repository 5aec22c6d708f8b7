#pragma once
/// The rig in the room: the devices' poses and one measured pose, in one tree of frames.
#include "procam/core/base/export.hpp"
#include "procam/core/geometry/frame_tree.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam {

/// Frames "rig", every device's name and "world". The pose may place the world relative to "projector" (which
/// means `projector`), the rig or any device, in either direction. Throws as FrameTree::set does.
PROCAM_EXPORT FrameTree room_frames(const Rig& rig, const RigProjector& projector, FrameTree::Link pose);

}  // namespace procam

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/rig/detail/room_frames_body.hpp"
#endif
