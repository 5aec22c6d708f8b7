#pragma once
/// A picture onto a surface: fit, crop, outline, holes and mask become a placement of the part of the picture
/// that shows, and an alpha mask over that part.
///
///   const LaidOut laid = surface::lay_out(solved, picture.size());
///   scene.items.push_back({laid.placement, laid.part(picture)});
///   scene.items.back().mask = laid.mask;
///
/// Nothing of this costs anything in a frame: the part is a view into the picture, the fit is folded into the
/// surface's homography or its mesh's uv once. It holds for all pictures of one size; while the surface
/// moves, only laid.placement's pose changes. What is not covered by the picture (Fit::kContain) is not
/// there: what lies behind it shows.
#include "procam/core/base/export.hpp"
#include "procam/core/surface/surface.hpp"

namespace procam::surface {

struct LaidOut {
  Placement placement;  ///< of the part of the picture that shows
  int x = 0, y = 0;     ///< the part's first pixel
  ImageSize size;       ///< the part's
  ImageU8 mask;         ///< alpha over the part; empty without outline, holes and mask

  /// Of a picture of the size that was laid out.
  ViewU8 part(ViewU8 picture) const {
    ViewU8 view(&picture.at(x, y), size.width, size.height, picture.channels, picture.stride);
    return view;
  }
};

/// Pixels of a mask's longer side where it is drawn from polygons.
inline constexpr int kMaskSide = 2048;

/// The crop is taken to whole pixels of the picture, half a pixel off at most, and what is left then fills
/// its place exactly. A picture of one pixel (a colour) fills the area with every fit, and so does any
/// picture on a surface without an aspect.
///
/// The mask holds the exact share of each of its pixels inside the outline and outside the holes, times the
/// mask picture there. Sampled like a picture, an edge lies where it belongs to some hundredths of a mask
/// pixel and is as soft as one or two of them.
///
/// Throws Error(kInput), naming the surface, for a crop without area or beyond the picture and for a shape
/// with a fault; std::invalid_argument for an empty picture.
PROCAM_EXPORT LaidOut lay_out(const Placement& placement, const Surface& surface, ImageSize picture);
inline LaidOut lay_out(const SolvedSurface& solved, ImageSize picture) {
  return lay_out(solved.placement, solved.surface, picture);
}

}  // namespace procam::surface
