#pragma once
/// Surfaces: where content belongs in the room, and where it ends up once solved.
///
/// Content coordinates (u, v) are fractions of the content's area: (0, 0) its top-left corner, (1, 1) its
/// bottom-right corner; an image of W x H pixels has pixel x = u W - 1/2, y = v H - 1/2. They do not change
/// with the resolution. Surface frame: x right, y down as the content is read, z into the wall, metres; on a
/// plane, content lives on z = 0.
///
/// The geometries are a closed set: one file in core/surface/ and one alternative in the variant each. Planes
/// and flat pixel surfaces are drawn by their homography, all others as triangles (mesh_of).
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/lens/projector.hpp"
#include "procam/core/surface/bezier.hpp"
#include "procam/core/surface/content_layout.hpp"
#include "procam/core/surface/cylinder.hpp"
#include "procam/core/surface/grid.hpp"
#include "procam/core/surface/mesh.hpp"
#include "procam/core/surface/pixels.hpp"
#include "procam/core/surface/planar.hpp"
#include "procam/core/surface/sphere.hpp"

namespace procam {

using SurfaceGeometry = std::variant<PlanarSurface, PixelSurface, GridSurface, BezierSurface, CylinderSurface,
                                     SphereSurface, MeshSurface>;

struct Surface {
  std::string name;
  SurfaceGeometry geometry;
  std::vector<double> weights;  ///< one a pair, 1/sigma^2 up to a common factor; empty: all equal
  std::string content;          ///< file shown when the tool is given none; may be empty
  ContentLayout layout = {};
  ContentShape shape = {};
};

/// Surfaces in the room hide each other as the projector sees them; where two lie together (closer than a
/// thousandth of their distance), and for pixel surfaces, the later covers the earlier.
struct SurfaceSet {
  std::vector<Surface> surfaces;
};

/// How far triangles may be from a curved surface, metres.
inline constexpr double kTessellationTolerance = 1e-4;

/// How far triangles may be from a curved surface in projector pixels, pixels.
inline constexpr double kPixelTolerance = 0.1;

/// The triangles that a surface is drawn as; none for those drawn by homography. Of a curved pixel surface the vertices are
/// (x, y, 0) in projector pixels. Throws Error(kInput) naming the surface and its fault for a shape that cannot be.
PROCAM_EXPORT std::shared_ptr<const Mesh> mesh_of(const Surface& surface);

/// Where it stands in the room; nullptr for a pixel surface.
PROCAM_EXPORT const InRoom* place_of(const SurfaceGeometry& geometry);
/// The same, to be changed.
PROCAM_EXPORT InRoom* place_of(SurfaceGeometry& geometry);

using Placement = std::variant<PlacedPlane, PlacedPixels, PlacedMesh>;

/// A curved pixel surface as light: each vertex on the ray of its pixel, in the projector's frame, one metre along the axis. A
/// vertex whose pixel has no ray is skipped with its triangles. Requires `placed.mesh`.
PROCAM_EXPORT PlacedMesh mesh_on_rays(const PlacedPixels& placed, const Projector& projector);

/// The pixel that a content position has on a pixel surface (it may lie outside the frame); nullopt on and beyond the horizon,
/// and outside a curved surface's triangles.
PROCAM_EXPORT std::optional<Vec2> pixel_at(const PlacedPixels& placed, const Vec2& uv);

/// How a surface looks from the projector.
struct Visibility {
  double covered_share = 0;  ///< of the content's area (inside outline and mask) that falls inside
  /// the projector's picture, 0..1
  bool facing = true;           ///< the projector stands on the side that content is read from
  double incidence_deg = 0;     ///< angle between light and surface normal at the content's centre
  double mm_per_pixel_min = 0;  ///< size of a projector pixel on the surface: the finest and
  /// the coarsest direction over the content (0 for pixel surfaces; of curved surfaces and meshes where light
  /// meets them at less than 80 degrees)
  double mm_per_pixel_max = 0;
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

#ifndef PROCAM_CORE_COMPILED
#include "procam/core/surface/detail/surface_body.hpp"
#endif
