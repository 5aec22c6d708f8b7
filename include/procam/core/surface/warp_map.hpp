#pragma once
/// Warps, in both directions, for programs that draw through a table instead of a lens model.
///
/// A map answers "what does this projector pixel show", a mesh "where does this piece of the content go".
/// Content coordinates are those of core/surface/surface.hpp: (0, 0) the content's top-left corner, (1, 1) its
/// bottom-right one. Pixels: see docs/conventions.md.
#include <array>

#include "procam/core/base/image.hpp"

namespace procam {

/// For the centre of every projector pixel, the content coordinates that its light shows.
struct WarpMap {
  ImageF content;  ///< the projector's size, 3 channels: u, v, and 1 where the content is shown; else 0 0 0

  ImageSize size() const { return content.size(); }
  bool shows(int x, int y) const { return content.at(x, y, 2) != 0; }
  Vec2 at(int x, int y) const { return Vec2(content.at(x, y, 0), content.at(x, y, 1)); }
};

/// Triangles over the content, with the projector pixel of each corner (it may lie outside the picture).
/// Between the corners a renderer interpolates linearly: see surface/warp.hpp for the error of that.
struct WarpMesh {
  ImageSize projector;
  Points2 content;
  Points2 pixels;                             ///< one a content point
  std::vector<std::array<int, 3>> triangles;  ///< indices of points
};

}  // namespace procam
