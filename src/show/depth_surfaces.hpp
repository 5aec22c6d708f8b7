#pragma once
/// The texts that name a depth camera as the source of surfaces:
///
///   depth:SOURCE                                        planes with names
///   depth-shape:SOURCE[,region=X:Y:WIDTHxHEIGHT]        one surface of any shape, "shape"
///
/// SOURCE as device::open_depth() takes it, the region in pixels of the depth camera.
#include <optional>
#include <string>

#include "procam/depth/height_field.hpp"

namespace procam::show {

struct DepthSurfaces {
  std::string source;
  bool is_shape = false;
  std::optional<depth::PixelRegion> region;
};

/// Throws Error(kInput) for a region that is none.
DepthSurfaces parse_depth_surfaces(const std::string& text);

/// Is the content made from the heights of the shape?
bool is_height_content(const std::string& content);

}  // namespace procam::show
