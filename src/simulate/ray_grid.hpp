#pragma once
/// Directions of a camera's rays: nodes on every second pixel border, linear between, right to 1e-3 px for
/// the strongest lenses, as the second derivative of the undistortion is below 1e-3 px per px^2. Every second
/// node of a row is exact, the others come from those by a cubic.
#include <vector>

#include "procam/core/lens/camera.hpp"
#include "procam/simulate/lens_deviation.hpp"

namespace procam::simulate::internal {

/// Pixels a cell and axis. Cell borders lie at -0.5, kRayCell - 0.5, ...
constexpr int kRayCell = 2;

struct RayNode {
  bool valid = false;
  /// z = 1 where possible, so that linear interpolation stays on the plane.
  Vec3 direction_in_camera = Vec3::Zero();
};

inline int ray_cells(int pixels) {
  return (pixels + kRayCell - 1) / kRayCell;
}

inline RayNode ray_node(const Camera& camera, const LensDeviation& deviation, int column, int row) {
  const Vec2 pixel(kRayCell * column - 0.5, kRayCell * row - 0.5);
  const std::optional<Vec3> direction = camera.unproject(pixel - deviation.at(pixel));
  if (!direction) return {};
  return {true, direction->z() > 0.1 ? Vec3(*direction / direction->z()) : *direction};
}

/// The nodes along one row of borders, one more than cells.
inline std::vector<RayNode> ray_node_row(const Camera& camera, const LensDeviation& deviation, int row) {
  std::vector<RayNode> nodes;
  const int cells = ray_cells(camera.size.width);
  nodes.reserve(std::size_t(cells) + 1);
  for (int i = 0; i <= cells; ++i)
    nodes.push_back(i % 2 == 0 || i == cells ? ray_node(camera, deviation, i, row) : RayNode{});
  // Every second one by the cubic through its neighbours: two pixels apart it is right to 1e-6 px.
  for (int i = 1; i < cells; i += 2) {
    const std::size_t k = std::size_t(i);
    const auto in_front = [&](std::size_t j) {
      return nodes[j].valid && nodes[j].direction_in_camera.z() == 1;
    };
    if (i >= 3 && i + 3 <= cells - cells % 2 && in_front(k - 3) && in_front(k - 1) && in_front(k + 1) &&
        in_front(k + 3))
      nodes[k] = {true, 0.5625 * (nodes[k - 1].direction_in_camera + nodes[k + 1].direction_in_camera) -
                            0.0625 * (nodes[k - 3].direction_in_camera + nodes[k + 3].direction_in_camera)};
    else
      nodes[k] = ray_node(camera, deviation, i, row);
  }
  return nodes;
}

/// A cell by its corners.
struct RayCell {
  const RayNode &a, &b, &c, &d;  ///< upper left and right, lower left and right

  bool valid() const { return a.valid && b.valid && c.valid && d.valid; }
  /// s and t from 0 to 1 across the cell.
  Vec3 direction(double s, double t) const {
    return (1 - t) * ((1 - s) * a.direction_in_camera + s * b.direction_in_camera) +
           t * ((1 - s) * c.direction_in_camera + s * d.direction_in_camera);
  }
};

}  // namespace procam::simulate::internal
