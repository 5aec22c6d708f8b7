#pragma once
/// Where verify-projection's surface is, with what states it.
#include <string>

#include "procam/analyze/verify.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/surface/surface.hpp"
#include "procam/io/text.hpp"

namespace procam::tools {

/// The surface called `wanted`, or the only one. Throws Error(kInput) naming those that `file` has.
Surface& pick_surface(SurfaceSet& set, const std::string& wanted, const std::string& file);
/// Throws Error(kInput) unless it is a plane with a position in the world or the rig.
PlanarSurface& plane_of(Surface& surface);

/// Where the world is, with what states it.
struct KnownWorld {
  PoseWithCovariance rig_from_world;
  MatX jacobian_camera;  ///< see analyze::StatedSurface
  Diagnostics diagnostics;
};

/// One of them or none.
struct WorldFiles {
  std::string pose, markers;
};

/// The pose of the frame that the planar surface is placed in: from a pose file, or from printed markers in the
/// flat-lit picture. Throws Error(kInput) for a frame that neither states.
KnownWorld frame_of(const Surface& surface, const WorldFiles& files, const Rig& rig, const RigCamera& camera,
                    const RigProjector& projector, const ImageU8& flat_lit);

/// The surface in the rig; `sigma` of its pose adds to the world's.
analyze::StatedSurface state_surface(const Surface& surface, const PlanarSurface& plane,
                                     const KnownWorld& world, const io::LengthAndAngle& sigma);

/// Corners of the content on the surface, metres.
Points2 content_outline(const Surface& surface, const RigProjector& projector, const Pose& rig_from_world);

}  // namespace procam::tools
