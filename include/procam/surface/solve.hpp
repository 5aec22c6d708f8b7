#pragma once
/// From what was measured to what can be drawn: each surface's homography, its pose relative to the
/// projector, and how it looks from there.
///
///   SolvedSurfaceSet solved = surface::solve_surfaces(set, rig.projector(), projector_from_world);
///
/// The homography is the weighted least-squares one of core/geometry/homography_fit.hpp: content -> the surface's own
/// plane (metres), or content -> projector pixels. Its denominators are positive in front of the horizon.
/// Placement: projector_from_surface = projector_from_frame * frame_from_surface, for frame "projector" (the
/// identity), "rig" (the rig's own pose) or "world" (`projector_from_world`). Pixels, frames: see
/// docs/conventions.md.
#include "procam/core/base/export.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/core/surface/surface.hpp"

namespace procam::surface {

struct SolveOptions {
  /// Without it `SolvedSurface::visibility`, `corners_px` and the remarks on them stay empty, which takes a
  /// hundredth of the time: for a running show.
  bool visibility = true;
  /// Below this share of the content inside the projector's picture a warning is given.
  double min_covered_share = 0.999;
  /// Warn when light meets the surface at a larger angle to its normal: errors in the pose grow with 1 /
  /// cos^2.
  double largest_incidence_deg = 70;
  /// Rate at which good pairs with Gaussian errors get an "outlying_pair" warning, a surface.
  double false_alarm_rate = 1e-3;
  /// Deviations below these are never called out: files carry rounded numbers.
  double smallest_outlier_mm = 0.1;
  double smallest_outlier_px = 0.1;
};

/// Any number of surfaces; an empty set gives an empty result.
///
/// Throws Error naming the surface: kInput for an empty or repeated name, values that are not finite, lists
/// of different lengths, an unknown frame, an outline with a fault, or frame "world" without
/// `projector_from_world`; kNotEnoughData for fewer than four pairs; kDegenerate for collinear or repeated
/// points and points on both sides of the horizon.
///
/// Diagnostics, a surface each (`SolvedSurface::diagnostics`): failures "behind_projector" and "edge_on", no
/// light can land, and "too_small", all of it within 4 projector pixels; warnings "outside_picture", "partly_outside",
/// "seen_from_behind", "mirrored", "grazing", "outlying_pair", "implausible_units" (farther than 200 m, wider than 100 m,
/// content coordinates in pixels).
PROCAM_EXPORT SolvedSurfaceSet solve_surfaces(const SurfaceSet& set, const RigProjector& projector,
                                              const std::optional<Pose>& projector_from_world = std::nullopt,
                                              const SolveOptions& options = {});

/// The same surfaces after the projector was moved in its rig: those in the frame of the rig move in the projector's, with
/// all else as in move_to(). Surfaces in the world are left to that.
PROCAM_EXPORT void move_in_rig(SolvedSurfaceSet& solved, const RigProjector& projector);

/// The same surfaces from another pose of the projector: what stands in the world moves, homographies and
/// meshes stay. For every frame of a drive: visibility, corners and remarks are left as they were solved, and
/// nothing is allocated.
PROCAM_EXPORT void move_to(SolvedSurfaceSet& solved, const RigProjector& projector,
                           const Pose& projector_from_world);

/// All diagnostics of the set, each message beginning with its surface's name.
PROCAM_EXPORT Diagnostics diagnostics_of(const SolvedSurfaceSet& solved);

}  // namespace procam::surface
