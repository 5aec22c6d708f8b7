#pragma once
/// A viewer's pose relative to the projector, and the scene from there.
#include "procam/core/base/export.hpp"
#include "procam/core/lens/camera.hpp"
#include "procam/core/surface/scene.hpp"

namespace procam::render {

/// An eye with its picture, in optical axes.
struct Viewpoint {
  Camera camera;
  Pose camera_from_projector;
};

/// In front of the scene's surfaces, looking along their mean normal from the side they are read from,
/// upright as they are read, far enough back to see all of them. nullopt when all are pixel surfaces.
PROCAM_EXPORT std::optional<Viewpoint> facing_viewpoint(const Scene& scene, ImageSize size = {960, 640});

/// The same surfaces with the same content in another frame: what a renderer draws for a device that stands
/// there. Pixel surfaces belong to the projector's picture and are skipped.
PROCAM_EXPORT Scene seen_from(const Pose& other_from_projector, const Scene& scene);

}  // namespace procam::render
