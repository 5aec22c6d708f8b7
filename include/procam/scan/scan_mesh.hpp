#pragma once
/// A scan -> a mesh that keeps edges and holes, with no more triangles than a stated deviation needs.
///
/// The image is split into right-angled triangles, each along its hypotenuse, until none deviates: at the middle of every
/// hypotenuse, down to single pixels, the measured inverse depth (in which planes are linear) is within the tolerance of
/// the line between its ends (right-triangulated irregular networks: W. Evans, D. Kirkpatrick, G. Townsend,
/// Algorithmica 30(2), 2001). Neighbours are split alike, so no cracks appear. Triangles that hold pixels without a depth, or
/// a step in depth, are split to single pixels, and those without three corners on one surface are omitted. Before, small holes
/// are filled: their inverse depth is interpolated along x and y.
///
/// Content coordinates are those of the camera's image, (0, 0) .. (1, 1): content looks undistorted from where the camera
/// is.
#include "procam/core/base/export.hpp"
#include "procam/core/geometry/mesh.hpp"
#include "procam/scan/scan.hpp"

namespace procam::scan {

struct MeshOptions {
  /// Largest deviation of a measured depth from the mesh, metres ...
  double max_deviation = 0.5e-3;
  /// ... or this many standard deviations of its noise, if they are more.
  double max_sigmas = 3;
  /// Neighbouring pixels are on two surfaces when the surface between them would be seen at a flatter angle than this,
  /// radians.
  double min_angle = 5 * kDegree;
  /// Holes of so many pixels along x or y are bridged where the surface goes on behind them: content would have specks.
  /// Wider ones, and steps in depth, stay open. 0: all do.
  int max_hole = 8;
};

/// In the rig's frame. Throws Error(kNotEnoughData) when no three neighbouring pixels are measured.
PROCAM_EXPORT Mesh mesh_of(const Scan& scan, const MeshOptions& options = {});

}  // namespace procam::scan
