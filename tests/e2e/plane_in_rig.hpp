#pragma once
#include <string>

#include "procam/core/surface/surface.hpp"

namespace procam::test {

/// A rectangle whose content fills it, width and height in metres, its first corner at the surface's origin.
inline Surface plane_in_rig(const std::string& name, double width, double height,
                            const Pose& rig_from_surface) {
  PlanarSurface plane;
  plane.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  plane.points = {{0, 0}, {width, 0}, {width, height}, {0, height}};
  plane.frame = "rig";
  plane.frame_from_surface = rig_from_surface;
  Surface surface;
  surface.name = name;
  surface.geometry = plane;
  return surface;
}

}  // namespace procam::test
