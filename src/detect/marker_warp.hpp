#pragma once
/// The edges of one marker, and the homography that explains them.
#include <functional>

#include "procam/core/base/image.hpp"
#include "procam/core/board/marker.hpp"
#include "procam/core/geometry/homography.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam::detect {

/// The print's plane (unit coordinates) in the image: a homography, then the lens where it is known.
struct MarkerWarp {
  Mat3 plane_from_marker = Mat3::Identity();  ///< to pixels, or to the plane z = 1 before a lens
  const Camera* lens = nullptr;

  /// Through the corners. nullopt where the lens cannot say or they span no area.
  static std::optional<MarkerWarp> through(const std::array<Vec2, 4>& corners, const Camera* lens);
  std::optional<Vec2> operator()(const Vec2& on_marker) const;
};

struct FoundEdges {
  std::vector<MarkerEdge> edges;
  double blur = 0;  ///< sigma, pixels
};

/// All pieces of edges whose profile could be fitted, looked for where `warp` predicts them.
FoundEdges find_edges(const ViewU8& image, const MarkerCells& codes, int id, const MarkerWarp& warp);

struct WarpFit {
  MarkerWarp warp;
  Eigen::Matrix<double, 8, 8> corner_covariance;
  double chi2_per_dof = 1;  ///< of the edges that are left
};

/// Adds to the edges' variances what their noise does not explain of their misfit from the marker's own fit,
/// up to a share of the blur. Gamma, glare and neighbouring edges give profiles that are no blurred step, and
/// each edge an offset of its own; a misfit beyond that share is a curled sheet or another lens.
void believe_misfit(const WarpFit& fit, double blur, std::vector<MarkerEdge>& edges);

/// Robust least squares over all edges; those it does not explain are removed from the list. nullopt when too
/// few are left on any side.
std::optional<WarpFit> fit_warp(std::vector<MarkerEdge>& edges, const MarkerWarp& start);

}  // namespace procam::detect
