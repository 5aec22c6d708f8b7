#pragma once
/// Where a camera of the rig sees each projector pixel's light on known surfaces, and how that moves.
///
/// The camera's image is averaged over k x k pixels, so that it is at most `max_width` wide: the working image. Its pixel
/// x covers the camera pixels k x .. k x + k - 1 and has its centre at k x + (k - 1) / 2. The ray of a node (every
/// kNodeSpacing working pixels) meets the nearest surface at X; the projector lights X with its pixel
///
///   u = project(projector_from_rig X)
///
/// unless another surface is in between. Between nodes of one surface u is linear.
///
/// Cells are squares of the working image that lie on one lit surface. Their centres know how their light moves, to first
/// order, by left increments [w, v] in the rig's frame. With r the direction of the light and n the normal, a projector
/// that moves takes the light to X + (I - r n^T / (n . r)) (w x X + v); a surface that moves takes it along r to
/// X + r n . (w x X + v) / (n . r).
///
/// Frames, pixels: docs/conventions.md.
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/core/surface/surface.hpp"

namespace procam::watch {

/// A plane surface that light falls on.
struct WatchedSurface {
  std::string name;
  Pose rig_from_surface;  ///< x, y on it, z into the wall
  Points2 outline;        ///< a simple polygon on z = 0, metres: where light is certain to fall on it
};

/// The plane surfaces of a set, with the quadrilateral of their content, as they are placed before the projector. Curved
/// surfaces and those in projector pixels are omitted: where these are in the room is not known, or not yet handled.
PROCAM_EXPORT std::vector<WatchedSurface> watched_surfaces(const SolvedSurfaceSet& solved,
                                                           const RigProjector& projector);

struct GeometryOptions {
  int max_width = 640;    ///< of the working image, pixels: finer costs time, and gains little
  int cell = 24;          ///< side of a cell, working pixels
  int cell_spacing = 24;  ///< between the centres of neighbouring cells
};

/// Centre of a cell.
struct LitCell {
  Vec2 pixel = Vec2::Zero();            ///< working pixel of the centre; whole numbers
  Vec2 projector_pixel = Vec2::Zero();  ///< that lights it
  int surface = 0;
  Vec3 point_in_rig = Vec3::Zero();
  Vec3 ray_in_rig = Vec3::UnitZ();       ///< direction of its light, unit length
  Vec3 normal_in_rig = Vec3::UnitZ();    ///< of the surface
  Mat23 pixel_by_point = Mat23::Zero();  ///< d (working pixel) / d (point in the rig's frame), per metre

  /// The light's way on the wall when the projector moves by [w, v]: 3 x 6.
  PROCAM_EXPORT Eigen::Matrix<double, 3, 6> by_projector() const;
  /// ... and when its surface does.
  PROCAM_EXPORT Eigen::Matrix<double, 3, 6> by_surface() const;
  /// The way of the light across the surface when the surface moves, without the surface's way along itself.
  PROCAM_EXPORT Eigen::Matrix<double, 3, 6> across_surface() const;
};

struct LightGeometry {
  static constexpr int kNodeSpacing = 8;  ///< working pixels

  ImageSize camera_size, working_size, projector_size;
  int average = 1;                 ///< k
  double projector_px_per_px = 1;  ///< projector pixels a working pixel, median over the cells
  int half_cell = 12;
  ImageF node_pixel;                 ///< two channels, projector pixel at each node
  Image<std::int16_t> node_surface;  ///< -1: no known light there
  std::vector<std::string> surfaces;
  std::vector<LitCell> cells;

  /// Is the working pixel between four nodes of one surface?
  PROCAM_EXPORT bool is_lit(int x, int y) const;
};

/// Throws std::invalid_argument for options out of range or an outline with fewer than three corners. Without any lit
/// cell the result has none.
PROCAM_EXPORT LightGeometry light_geometry(const RigCamera& camera, const RigProjector& projector,
                                           const std::vector<WatchedSurface>& surfaces,
                                           const GeometryOptions& options = {});

}  // namespace procam::watch
