#pragma once
/// A surface given in the projector's own pixels.
#include <algorithm>
#include <array>
#include <memory>

#include "procam/core/base/types.hpp"
#include "procam/core/geometry/mesh.hpp"
#include "procam/core/surface/bezier.hpp"
#include "procam/core/surface/grid.hpp"

namespace procam {

enum class PixelShape {
  kFlat,   ///< a homography through pairs
  kGrid,   ///< columns x rows points at regular content coordinates, bilinear between (GridSurface)
  kBezier  ///< columns x rows control points of one smooth patch (BezierSurface)
};

/// Right for one placement of the projector. The projector's lens is not applied: whoever dragged the points saw it already.
///
/// Flat: N >= 4 pairs of content coordinates and projector pixels, a pure homography. Grid and Bezier: the pixels are
/// those of columns x rows points row by row, the first at (u, v) = (0, 0), and `content` is empty.
struct PixelSurface {
  Points2 content;  ///< source (u, v); empty unless flat
  Points2 pixels;   ///< destination, projector pixels
  PixelShape shape = PixelShape::kFlat;
  int columns = 0, rows = 0;  ///< of a grid or a Bezier patch, 2 to 16

  bool is_curved() const { return shape != PixelShape::kFlat; }
  /// The projector pixel of a content position; for grids and Bezier patches without a fault.
  Vec2 point(const Vec2& uv) const {
    return shape == PixelShape::kGrid ? as_grid().point(uv).head<2>() : as_bezier().point(uv).head<2>();
  }
  /// Why a grid or a Bezier patch cannot be drawn; nullptr for a good one, and for a flat surface.
  const char* fault() const {
    if (!is_curved()) return nullptr;
    if (columns < 2 || rows < 2 || columns > BezierSurface::kMax || rows > BezierSurface::kMax)
      return "it has fewer than 2 or more than 16 columns or rows";
    return shape == PixelShape::kGrid ? as_grid().fault() : as_bezier().fault();
  }

  /// The same in three dimensions: (x, y, 0), pixels instead of metres.
  GridSurface as_grid() const {
    GridSurface grid;
    grid.columns = columns;
    grid.rows = rows;
    grid.points = lifted();
    return grid;
  }
  BezierSurface as_bezier() const {
    BezierSurface bezier;
    bezier.columns = columns;
    bezier.rows = rows;
    bezier.control_points = lifted();
    return bezier;
  }

 private:
  Points3 lifted() const {
    Points3 points;
    for (const Vec2& pixel : pixels) points.emplace_back(pixel.x(), pixel.y(), 0);
    return points;
  }
};

/// A pixel surface, solved.
struct PlacedPixels {
  Mat3 pixel_from_content = Mat3::Identity();  ///< (u, v, 1) -> projector pixel; of a curved one not used
  /// Of a curved one, else null: vertices (x, y, 0) in projector pixels.
  std::shared_ptr<const Mesh> mesh = {};
};

}  // namespace procam
