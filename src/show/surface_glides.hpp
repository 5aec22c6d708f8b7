#pragma once
/// Surfaces on their way to where a correction has found them (watch/correction.hpp), and back.
#include <map>
#include <string>

#include "procam/core/surface/surface.hpp"
#include "procam/watch/correction.hpp"

namespace procam::show {

class SurfaceGlides {
 public:
  struct Frames {
    Pose rig_from_projector;
    Pose rig_from_world;  ///< of a rig that stands still
  };

  /// The surface of that name moves by the left increment `moved` of rig_from_surface, from where `set` has it. `error`: by
  /// which its light moves, metres. Without a surface of that name in the room nothing moves.
  void begin(const SurfaceSet& set, const std::string& surface, const Vec6& moved, double error,
             const Frames& frames, double now);
  /// All surfaces go back to where they were before their first correction.
  void undo(const SurfaceSet& set, double now);

  bool is_idle() const { return moving_.empty(); }
  /// Puts the moving surfaces of `set` where they are at `now`. Those that have arrived move no more.
  void apply(SurfaceSet& set, double now);

 private:
  struct Before {
    Pose frame_from_surface;
    double error = 0;  ///< of all corrections together
  };
  std::map<std::string, watch::Glide> moving_;
  std::map<std::string, Before> before_;
};

}  // namespace procam::show
