#pragma once
/// Rooms to scan, and what the camera of a simulated session records of them.
///
///   sphere     a ball of 0.35 m radius before a wall
///   cylinder   a column of 0.25 m radius before a wall
///   corner     two walls that meet at 90 degrees
///   relief     a wavy wall: 30 mm high waves of 0.5 and 0.7 m length
///   steps      boards of 20 to 120 mm before a wall
///   alcove     two walls, a floor, a ball of 0.15 m, and a relief: for several stations
///   niche      two white walls at 80 degrees and a floor, which light each other
///   furnished  walls, floor, furniture, a dark picture, a thin pole, a curtain; a lacquered table top, a cabinet and a screen that
///              mirror 5 to 12 % of the light; all light each other
///   wall, ball one plane, a ball alone: a station may slide along them unseen
///
/// At 1 to 2 m from the camera, in the frame of the level's rig; albedos differ. Light and sensor are those of the
/// level (level_conditions()) as far as a room has them (room_view.hpp): gamma, vignetting, noise, blur and defocus;
/// not glare; indirect light in the last two rooms alone.
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/simulate/room_view.hpp"
#include "procam/simulate/session.hpp"

namespace procam::simulate {

PROCAM_EXPORT const std::vector<std::string>& scan_scenes();

/// In the frame of the rig's camera. Throws Error(kUnsupported) with the names there are.
PROCAM_EXPORT Room scan_scene(const std::string& name);

/// What the session's rig records while its projector shows `frames` on the room, with the truth. Throws
/// std::invalid_argument for a session without views, and as room_view() does.
PROCAM_EXPORT RoomView scan_view(const SimulatedSession& session, const Room& room,
                                 const std::vector<ImageU8>& frames);

/// The same by one camera and one projector of several.
PROCAM_EXPORT RoomView scan_view(const CaptureOptions& capture, const Room& room, const RigCamera& camera,
                                 const RigProjector& projector, const std::vector<ImageU8>& frames);

/// Where the whole rig stands at a station: 0 is where the room is described from, the others are 0.2 to 0.4 m away, look
/// at neighbouring parts of the room, and are rolled by two to three degrees.
PROCAM_EXPORT Pose room_from_rig(int station);

/// Where somebody stands a camera for the views of calibrate-room: `view` 0 is where the rig has it, the others are
/// half a metre to its sides, above and below, and look at the same part of the room.
PROCAM_EXPORT Pose moved_camera(const Pose& rig_from_camera, int view);

}  // namespace procam::simulate
