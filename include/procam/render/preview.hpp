#pragma once
/// What a person in the room would see: the placed surfaces with the frame's light on them.
///
/// Each pixel of the view is followed to the nearest surface and from there to the projector's pixel that
/// lights it, if no other surface of the scene stands in that light. There it is as bright as the frame is at
/// that pixel, times cos / d^2 (distance and incidence), exposed such that a tenth of what is lit is brighter
/// than full light. A plane is shown as a grey patch a little larger than its content; where the projector's
/// picture falls on it, black is not quite black. Surfaces are matt and do not light each other. Edges and
/// the borders of shadows are looked at 16 times a pixel.
#include "procam/render/cpu.hpp"
#include "procam/render/viewpoint.hpp"

namespace procam::render {

/// The view, RGB, of the camera's size. `frame` is what the projector shows (RGB, the projector's size).
/// Pixel surfaces have no place in the room and are left out. Throws std::invalid_argument for a frame of
/// another shape.
ImageU8 preview(const Scene& scene, const Projector& projector, ViewU8 frame, const Viewpoint& viewpoint,
                const RenderOptions& options = {});

}  // namespace procam::render
