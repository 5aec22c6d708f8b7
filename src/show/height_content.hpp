#pragma once
/// Content that is made from the heights of a live shape:
///
///   height:colours[,range=LOWEST..HIGHEST][,contours=DISTANCE]      height:colours,range=-50mm..80mm,contours=20mm
#include <memory>
#include <string>

#include "procam/depth/height_picture.hpp"
#include "procam/device/content_source.hpp"

namespace procam::show {

/// Throws Error(kInput) for a text that is none.
depth::HeightColours parse_height_content(const std::string& text);

/// The heights of the frame that is drawn; written and read by the show's thread.
struct ShownHeights {
  depth::HeightMap map;
};

/// Its picture is made anew for every frame, for `shown->map` as it is then. Throws Error(kInput) as
/// parse_height_content(). std::invalid_argument for a map without cells.
std::unique_ptr<device::ContentSource> height_content(const std::string& text,
                                                      std::shared_ptr<const ShownHeights> shown);

}  // namespace procam::show
