#pragma once
/// Where a surface stands: what all surfaces with metres have in common.
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
