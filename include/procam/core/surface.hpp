#pragma once
/// Surfaces: where content belongs in the room, and where it ends up once solved.
///
/// Content coordinates (u, v) are fractions of the content's area: (0, 0) its top-left corner, (1, 1) its
/// bottom-right corner; an image of W x H pixels has pixel x = u W - 1/2, y = v H - 1/2. They do not change
/// with the resolution. Surface frame: x right, y down as the content is read, z into the wall; content lives
/// on z = 0, metres.
///
/// A geometry is a closed set: one file or struct and one alternative in the variant each.
#include <optional>
#include <string>
#include <variant>

#include "procam/core/error.hpp"
#include "procam/core/pose.hpp"

namespace procam {

/// N >= 4 pairs of content coordinates and points on a placed plane. Works with any pose of the projector.
struct PlanarSurface {
  Points2 content;              ///< source (u, v)
  Points2 points;               ///< destination, metres in the surface's own plane
  std::string frame = "world";  ///< the frame the surface is placed in: "world", "rig", or "projector"
  Pose frame_from_surface;
};

/// N >= 4 pairs of content coordinates and projector pixels, as clicked or dragged: a pure homography, right
/// for one placement of the projector. The projector's lens is not applied: whoever dragged the corners saw
/// it already.
struct PixelSurface {
  Points2 content;  ///< source (u, v)
  Points2 pixels;   ///< destination, projector pixels
};

using SurfaceGeometry = std::variant<PlanarSurface, PixelSurface>;

struct Surface {
  std::string name;
  SurfaceGeometry geometry;
  std::vector<double> weights;  ///< one a pair, 1/sigma^2 up to a common factor; empty: all equal
  std::string content;          ///< file shown when the tool is given none; may be empty
};

struct SurfaceSet {
  std::vector<Surface> surfaces;  ///< drawn in this order, later over earlier
};

/// A planar surface, solved: content -> plane by a homography, plane -> pixel by the full projector model.
struct PlacedPlane {
  Mat3 plane_from_content = Mat3::Identity();  ///< (u, v, 1) -> metres on z = 0
  Pose projector_from_surface;
};

/// A pixel surface, solved.
struct PlacedPixels {
  Mat3 pixel_from_content = Mat3::Identity();  ///< (u, v, 1) -> projector pixel
};

using Placement = std::variant<PlacedPlane, PlacedPixels>;

/// How a surface looks from the projector.
struct Visibility {
  double covered_share = 0;     ///< of the content's area that falls inside the projector's picture, 0..1
  bool facing = true;           ///< the projector stands on the side that content is read from
  double incidence_deg = 0;     ///< angle between light and surface normal at the content's centre
  double mm_per_pixel_min = 0;  ///< size of a projector pixel on the surface: the finest and
  double mm_per_pixel_max = 0;  ///< the coarsest direction over the content (0 for pixel surfaces)
};

struct SolvedSurface {
  Surface surface;
  Placement placement;
  double rms = 0;                 ///< of the homography's pairs: metres (planar) or pixels
  std::vector<double> residuals;  ///< a pair each, same unit
  std::optional<Points2>
      corners_px;  ///< projector pixels of the content's corners (0,0) (1,0) (1,1) (0,1), if all exist
  Visibility visibility;
  Diagnostics diagnostics;
};

/// Surfaces solved for one placement of one projector; complete in itself.
struct SolvedSurfaceSet {
  std::string projector;                     ///< its name in the rig
  std::optional<Pose> projector_from_world;  ///< absent when no surface needed it
  std::vector<SolvedSurface> surfaces;
};

}  // namespace procam
