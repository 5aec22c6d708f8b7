#pragma once
/// Has anything moved since the calibration? The projected board on the walls of the show, seen by the rig's own camera
/// (analyze/verify.hpp), wall by wall.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/rig/rig.hpp"
#include "procam/core/surface/surface.hpp"
#include "procam/session/projected_board.hpp"

namespace procam::studio {

struct WallDrift {
  std::string surface;
  std::string projector;          ///< whose light it is; empty: the only one
  double rms_mm = 0, max_mm = 0;  ///< distance of the light from where the rig file puts it
  int marks = 0;
  bool checked = false;
  bool moved = false;   ///< beyond what the rig's covariance and the noise explain, 1 false alarm in 1000
  std::string remarks;  ///< what moved, or why the wall is not checked
};

/// "'wall 1': the light is off by 0.21 mm rms, 0.40 mm max (35 marks); nothing has moved"
std::string to_sentence(const WallDrift& wall);

struct Drift {
  std::vector<WallDrift> walls;
  /// The rig with the poses of the projectors corrected that have moved; each by the marks of all walls.
  std::optional<Rig> corrected;
  bool moved() const;
};

/// The projected board as the camera saw it.
struct DriftCapture {
  std::string projector;  ///< its name in the rig; empty: the only one
  session::ProjectedBoardCapture captured;
};

/// One projector after the other. Marks count for the surface, flat or curved, inside whose outline the rig file puts their light. Throws Error(kNotEnoughData)
/// where no surface has marks enough.
Drift check_drift(const Rig& rig, const SurfaceSet& surfaces, const std::vector<DriftCapture>& captured);

}  // namespace procam::studio
