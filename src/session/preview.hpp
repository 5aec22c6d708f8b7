#pragma once
/// Small images of a session's views.
#include <functional>
#include <string>
#include <vector>

#include "procam/core/base/types.hpp"
#include "procam/core/rig/light_map.hpp"
#include "procam/core/rig/view_image.hpp"

namespace procam::session {

/// The brightest of a view's frames, at most 480 pixels wide and high: the mean of scale x scale pixels of the green channel.
/// Throws std::invalid_argument without frames.
ViewImage preview(const std::string& view, const std::string& camera, const std::vector<ViewU8>& frames);

/// ViewImage::decoded of a camera's images: the middle of each scale x scale pixels. `projector_pixel` gives the pixel whose light
/// falls on camera pixel x, y; nullopt: not decoded.
ImageF decoded_preview(ImageSize camera,
                       const std::function<std::optional<Vec2>(int x, int y)>& projector_pixel);
ImageF decoded_preview(const LightMap& light);

}  // namespace procam::session
