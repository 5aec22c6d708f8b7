#pragma once
/// Content with depth for one viewer: where the eye is, and the things that are seen (render/viewer.hpp).
#include <string>

#include "procam/core/rig/rig.hpp"
#include "procam/core/surface/surface.hpp"

namespace CLI {
class App;
}

namespace procam::tools {

struct ViewerFlags {
  std::optional<Vec3> eye;  ///< metres, in the world; in the rig where nothing is placed in a world
  std::string things;       ///< surfaces file

  bool given() const { return eye.has_value(); }
};

void declare_viewer(CLI::App& app, ViewerFlags& flags);

/// Throws Error(kInput) for one flag without the other.
void check_viewer(const ViewerFlags& flags);

Vec3 eye_in_projector(const ViewerFlags& flags, const RigProjector& projector, const SolvedSurfaceSet& real);

/// The virtual things, placed for the projector of the real surfaces; whether its light reaches them does not
/// matter. Throws Error(kInput) for one that is given in projector pixels.
SolvedSurfaceSet solve_things(const ViewerFlags& flags, const RigProjector& projector,
                              const SolvedSurfaceSet& real);

}  // namespace procam::tools
