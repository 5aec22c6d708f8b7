#pragma once
/// Shows without a calibrated rig: corners dragged by hand, in projector pixels.
#include "procam/core/rig/rig.hpp"
#include "procam/core/surface/surface.hpp"
#include "procam/show/show_options.hpp"

namespace procam::show {

/// The whole content in an upright rectangle of projector pixels.
PixelSurface pixel_rectangle(const Vec2& corner, const Vec2& size);

/// Throws Error(kInput) for an option that only a rig gives a meaning.
void require_no_rig_needed(const ShowOptions& options);

/// Throws Error(kInput), naming `file`, unless all surfaces are in projector pixels.
void require_pixel_surfaces(const SurfaceSet& set, const std::string& file);

/// The frame: the display's, or ShowOptions::size for other outputs. Throws Error(kInput) where nothing states it.
ImageSize frame_size_without_rig(const ShowOptions& options);

/// A stand-in for the rig: one projector with this frame. No surface in projector pixels depends on its lens.
Rig stand_in_rig(ImageSize size);

/// A surface for each of the contents, side by side in the frame's middle; without contents one white surface, "wall".
SurfaceSet first_surfaces(std::map<std::string, std::string> contents, ImageSize size);

}  // namespace procam::show
