#pragma once
/// The edges of one marker, and the homography that explains them.
#include <functional>

#include "procam/core/camera.hpp"
#include "procam/core/homography.hpp"
#include "procam/core/image.hpp"
#include "procam/core/marker.hpp"

namespace procam::detect {

/// The print's plane (unit coordinates) in the image: a homography, then the lens where it is known.
struct MarkerWarp {
  Mat3 plane_from_marker = Mat3::Identity();  ///< to pixels, or to the plane z = 1 before a lens
  const Camera* lens = nullptr;

  /// Through the corners. nullopt where the lens cannot say or they span no area.
  static std::optional<MarkerWarp> through(const std::array<Vec2, 4>& corners, const Camera* lens);
  std::optional<Vec2> operator()(const Vec2& on_marker) const;
};

/// All pieces of edges whose profile could be fitted, looked for where `warp` predicts them.
std::vector<MarkerEdge> find_edges(const ViewU8& image, const MarkerCells& codes, int id,
                                   const MarkerWarp& warp);

struct WarpFit {
  MarkerWarp warp;
  Eigen::Matrix<double, 8, 8> corner_covariance;
};

/// Robust least squares over all edges; those it does not explain are removed from the list. nullopt when too
/// few are left on any side.
std::optional<WarpFit> fit_warp(std::vector<MarkerEdge>& edges, const MarkerWarp& start);

}  // namespace procam::detect
