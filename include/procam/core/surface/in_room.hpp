#pragma once
/// Placement of a surface: the common part of all surfaces in metres.
#include <string>

#include "procam/core/geometry/pose.hpp"

namespace procam {

struct InRoom {
  std::string frame = "world";  ///< the frame the surface is placed in: "world", "rig", or "projector"
  Pose frame_from_surface;
};

/// Which side of a curved surface the content is read from.
enum class SeenFrom { kOutside, kInside };

}  // namespace procam
