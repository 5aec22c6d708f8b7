#pragma once
/// What of a plane is free to project on: its outline with holes, and the largest rectangle that fits.
///
/// A plane's frame is a surface's: x right, y down as content is read, z into the plane
/// (docs/conventions.md). On a wall y is down; on a floor or table content is read from where the camera
/// stands, its lower edge nearest; on a ceiling its upper edge is nearest.
#include <optional>

#include "procam/core/base/export.hpp"
#include "procam/depth/planes.hpp"

namespace procam::depth {

/// A raster over a plane, in its frame: cell (i, j) covers `low` + `cell` * [i, i+1] x [j, j+1], metres.
struct PlaneRaster {
  Vec2 low = Vec2::Zero();
  double cell = 0.01;
  ImageU8 free;  ///< 1: the plane is seen there

  Vec2 corner(int i, int j) const { return low + cell * Vec2(i, j); }
};

struct FreeRectangle {
  Vec2 low = Vec2::Zero(), high = Vec2::Zero();  ///< metres in the plane's frame

  Vec2 size() const { return high - low; }
  double area() const { return size().x() * size().y(); }
};

/// One connected part: clockwise as seen by the reader, holes the other way round.
struct PlaneOutline {
  Points2 outer;
  std::vector<Points2> holes;
};

struct AreaOptions {
  double cell = 0.01;      ///< metres; made larger where a plane would have more than 2^18 cells
  double margin = 0.01;    ///< metres that the rectangle stays away from everything
  double min_side = 0.2;   ///< metres; rectangles that are narrower hold no content
  double min_part = 0.01;  ///< square metres: smaller parts and holes are not part of the outline
};

struct PlaneArea {
  Pose camera_from_plane;
  PlaneRaster raster;
  double area = 0;  ///< square metres, of the free cells
  std::vector<PlaneOutline> outlines;
  std::optional<FreeRectangle> rectangle;  ///< nullopt where none is large enough
};

/// Of the plane's labels as the camera sees them. Single pixels without a label do not make holes.
PROCAM_EXPORT PlaneArea area_of(const Planes& planes, std::size_t plane, const RayTable& rays, const Vec3& up,
                                const AreaOptions& options = {});

/// The largest rectangle of free cells, by the largest rectangle under the histogram that ends in each row (a
/// stack, time linear in the cells: D. Vandevoorde, "The maximal rectangle problem", Dr. Dobb's, 1998). Of
/// those with both sides `min_side` long or longer; `margin` is taken off each side after.
PROCAM_EXPORT std::optional<FreeRectangle> largest_rectangle(const PlaneRaster& raster, double min_side = 0,
                                                             double margin = 0);

/// Borders of the free cells, straightened by Douglas and Peucker's rule to one and a half cells.
PROCAM_EXPORT std::vector<PlaneOutline> outlines_of(const PlaneRaster& raster, double min_part);

}  // namespace procam::depth
