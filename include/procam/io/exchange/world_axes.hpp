#pragma once
/// Which way is up in the user's world: what has to be known before coordinates go to a program whose axes
/// mean something (y up, z up, left-handed ...).
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/core/base/types.hpp"

namespace procam::io {

enum class WorldUp {
  kZ,      ///< z up, x forward, y left: robots (ROS REP 103), CAD
  kY,      ///< y up, x right, z backward: OpenGL
  kMinusY  ///< y down, x right, z forward: an optical frame, and so the rig's own
};

/// "z", "y" or "-y"; else Error(kInput).
PROCAM_EXPORT WorldUp parse_world_up(const std::string& text);

/// Three directions as unit vectors in some axes; in a left-handed program's axes as well.
struct Directions {
  Vec3 right, up, forward;
};

/// The matrix that takes coordinates in the user's axes to those of a program, given what the three
/// directions are there; its determinant is -1 for a left-handed one.
PROCAM_EXPORT Mat3 program_from_world(const Directions& in_program, WorldUp up);

}  // namespace procam::io
