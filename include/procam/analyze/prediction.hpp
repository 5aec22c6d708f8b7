#pragma once
/// The error of the light over a whole surface, because of what, and what would help most.
///
///   const LightPath path = light_path(projector, "world", frame_from_surface, world_from_rig);
///   SurfacePrediction wall = predict_surface(path, plane_from_content, sources);
///   wall.rms_mm;  wall.causes.front().name;  wall.advice;
#include <string>
#include <vector>

#include "procam/analyze/landing_error.hpp"
#include "procam/analyze/monte_carlo.hpp"
#include "procam/core/base/export.hpp"

namespace procam::analyze {

/// One cause over the whole surface.
struct Cause {
  std::string name;       ///< "rig pose: rotation", "delay", "calibration", ...
  double rms_mm = 0;      ///< of this cause alone, over the lit points
  double without_mm = 0;  ///< what the surface's rms would be without it
};

/// A number of the sources or the placement turned up and down, the rest as it is: the error at the content's
/// middle.
struct Sweep {
  std::string name, unit;              ///< "distance", "m"
  double here = 0;                     ///< the value as it is
  std::vector<double> values, rms_mm;  ///< a curve; points without light are omitted
};

/// Every source, or its parts, over the points: largest first. Throws std::invalid_argument without points, and for points
/// of different sources.
PROCAM_EXPORT std::vector<Cause> rank_causes(const std::vector<const LandingError*>& points);

struct SurfacePrediction {
  std::string surface;
  Vec2 size = Vec2::Zero();  ///< of the content on the surface, along its middle lines, metres
  Points3 corners_in_rig;    ///< of the content, in the order of `corners`
  int columns = 0, rows = 0;
  Points2 content;                                   ///< of the grid's points, row by row: fractions (u, v)
  std::vector<std::optional<LandingError>> grid;     ///< nullopt: not lit by the projector's picture
  std::vector<std::optional<LandingError>> corners;  ///< (0,0) (1,0) (1,1) (0,1); nullopt: not lit
  double lit_share = 0;                              ///< of the grid
  double rms_mm = 0;                                 ///< over the lit points
  double worst_mm = 0;                               ///< rms of the worst lit point, corners included
  Vec2 worst_content = Vec2::Zero();                 ///< where that is
  double incidence_deg = 0;                          ///< largest over the lit points
  std::vector<Cause> causes;                         ///< parts where a source has them, largest first
  std::string advice;                                ///< the one change that helps most, and how much
  std::vector<Sweep> sweeps;
  std::vector<std::optional<LandingSpread>>
      drawn;  ///< Monte Carlo on the grid's points; empty: not asked for
  double drawn_rms_mm = 0;
  Diagnostics diagnostics;  ///< "grazing", "not_lit", "first_order"
};

/// `plane_from_content` takes (u, v, 1) to metres on the surface (PlacedPlane). `draws` > 0 asks for Monte
/// Carlo beside the closed form. Throws as landing_error() does, and Error(kDegenerate) when the projector's
/// picture lights no point of the content.
PROCAM_EXPORT SurfacePrediction predict_surface(const std::string& name, const LightPath& path,
                                                const Mat3& plane_from_content, const ErrorSources& sources,
                                                const std::optional<MonteCarloOptions>& draws = std::nullopt);

/// Sets `drawn` and its rms to those of all parts, each `drawn` of this surface by another shard. Throws
/// std::invalid_argument for parts of another grid, and without parts.
PROCAM_EXPORT void merge_draws(const std::vector<std::vector<std::optional<LandingSpread>>>& parts,
                               SurfacePrediction& prediction);

}  // namespace procam::analyze
