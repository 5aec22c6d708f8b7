#pragma once
/// A solved surface as tables: warp maps, maps of positions, warp meshes.
///
///   const WarpMap map = surface::warp_map(solved.placement, projector);
///   const WarpMesh mesh = surface::warp_mesh(solved.placement, projector, {40, 24}).mesh;
///
/// The projector's full model is followed, lens and skew included; what lies behind the projector, beyond the
/// horizon or outside the content is not shown, nor what its own nearer parts hide (other surfaces are not
/// asked: see nearest_surfaces). The maps are exact at pixel centres, up to the 24 bits of
/// their numbers. They agree with what render draws there.
#include <cstdint>

#include "procam/core/base/export.hpp"
#include "procam/core/lens/projector.hpp"
#include "procam/core/surface/surface.hpp"
#include "procam/core/surface/warp_map.hpp"

namespace procam::surface {

PROCAM_EXPORT WarpMap warp_map(const Placement& placement, const Projector& projector);

/// Where each pixel's light lands on the content: x, y, z in metres in the target frame, NaN in all three
/// where the content is not shown. Throws Error(kUnsupported) for a pixel surface, which has no place in the
/// room.
PROCAM_EXPORT ImageF position_map(const Placement& placement, const Projector& projector,
                                  const Pose& target_from_projector = Pose::identity());

/// Which surface the light of each pixel meets first, by its place in the set; -1: none. As renderers have
/// it: by distance, of two that lie together (within a thousandth of it) the later; a pixel surface covers
/// what is before it in the set and is covered by what comes after. Outside its outline and in its holes a
/// surface is not there.
PROCAM_EXPORT Image<std::int16_t> nearest_surfaces(const SolvedSurfaceSet& solved,
                                                   const Projector& projector);

/// One surface of a set, or all of it (nullptr), as its light meets it: what other surfaces hide is not shown.
struct PROCAM_EXPORT VisiblePart {
  const SolvedSurfaceSet& solved;
  const SolvedSurface* chosen = nullptr;
  Image<std::int16_t> nearest;  ///< nearest_surfaces()

  VisiblePart(const SolvedSurfaceSet& set, const Projector& projector, const SolvedSurface* surface);
  bool has(int x, int y) const;
  /// Of the projector's pixels, those that show it.
  double share() const;
};

/// 1, or `weight`, where the part is shown, else 0.
PROCAM_EXPORT ImageF alpha_map(const VisiblePart& part, const ImageF* weight = nullptr);
/// warp_map() of the chosen surface without what others hide: outline and holes do nothing to a map.
PROCAM_EXPORT WarpMap warp_map(const VisiblePart& part, const Projector& projector);
/// position_map() of each surface where it is the nearest. Of several, pixel surfaces are skipped.
PROCAM_EXPORT ImageF position_map(const VisiblePart& part, const Projector& projector,
                                  const Pose& target_from_projector);

/// Cells of the content across and down; each becomes two triangles.
struct MeshGrid {
  int columns = 64;
  int rows = 36;
};

struct WarpGrid {
  WarpMesh mesh;
  /// How far, in projector pixels, linear interpolation puts places between the corners from where they
  /// belong, at worst over those that belong into the picture. It falls with the square of the triangles'
  /// size.
  double largest_error_px = 0;
};

/// Planes and pixel surfaces: a regular grid over the content; cells with a corner that no light can reach
/// are skipped. Curved surfaces and meshes: the triangles that they are made of (`grid` is ignored then),
/// the farthest first, so that the nearer cover them. Throws std::invalid_argument unless there are 1 to 1024
/// columns and rows.
PROCAM_EXPORT WarpGrid warp_mesh(const Placement& placement, const Projector& projector,
                                 const MeshGrid& grid = {});

}  // namespace procam::surface
