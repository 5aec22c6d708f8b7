#pragma once
/// `--surfaces depth:SOURCE`: surfaces as a depth camera of the rig sees them, while the show runs.
#include <memory>

#include "procam/show/projection.hpp"
#include "procam/show/room_watch.hpp"

namespace CLI {
class App;
}

namespace procam::tools {

struct DepthRoomFlags {
  std::string camera;
  double scale = 0.001, delay = 0;
  std::optional<Vec3> up;
  bool silhouettes = false;  ///< objects in front of the room are masked
};
void declare_depth_room(CLI::App& app, DepthRoomFlags& flags);

/// Does it begin with "depth:"?
bool is_depth_room(const std::string& surfaces);

/// The rig's pose comes from the projection's poses, or is fixed. Loss of the camera follows
/// --blank-on-stale / --freeze-on-stale, as for poses.
std::unique_ptr<show::DepthSurfaceSource> watch_room(const std::string& surfaces, const DepthRoomFlags& flags,
                                                     const Rig& rig,
                                                     const show::ProjectionOptions& projection,
                                                     bool rig_is_world);

}  // namespace procam::tools
