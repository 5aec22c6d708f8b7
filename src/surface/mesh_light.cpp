#include "mesh_light.hpp"

#include <algorithm>
#include <cmath>

namespace procam::surface {

namespace {

constexpr int kTilePixels = 32;

/// Directions within an angle of an axis.
struct Cone {
  Vec3 axis = Vec3::UnitZ();
  double angle = kPi;  ///< all of them, until something smaller is known

  bool touches(const Cone& other) const {
    const double between = std::acos(std::clamp(axis.dot(other.axis), -1.0, 1.0));
    return between <= angle + other.angle;
  }
};

/// A cap of the sphere below 90 degrees is convex: what holds the corners holds all between them.
template <std::size_t N>
Cone cone_around(const std::array<Vec3, N>& directions) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& direction : directions) sum += direction.normalized();
  Cone cone;
  if (!(sum.norm() > 1e-9)) return cone;
  const Vec3 axis = sum.normalized();
  double angle = 0;
  for (const Vec3& direction : directions)
    angle = std::max(angle, std::acos(std::clamp(axis.dot(direction.normalized()), -1.0, 1.0)));
  if (angle < 0.49 * kPi) cone = {axis, angle};
  return cone;
}

Cone cone_of_tile(const Projector& projector, int x0, int y0) {
  std::array<Vec3, 9> directions;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) {
      const auto ray =
          projector.emit(Vec2(x0 + 0.5 * i * kTilePixels - 0.5, y0 + 0.5 * j * kTilePixels - 0.5));
      if (!ray) return {};  // beyond the lens model: every triangle is asked
      directions[std::size_t(3 * j + i)] = ray->direction;
    }
  Cone cone = cone_around(directions);
  cone.angle *= 1.1;  // lenses bend the tile's sides
  return cone;
}

}  // namespace

MeshLight::MeshLight(const Projector& projector, const PlacedMesh& placed)
    : projector_(projector), placed_(placed) {
  const Mesh& mesh = *placed.mesh;
  std::vector<Cone> cones;
  for (const std::array<int, 3>& corners : mesh.triangles) {
    std::array<Vec3, 3> points;
    for (std::size_t i = 0; i < 3; ++i)
      points[i] = placed.projector_from_surface * mesh.vertices[std::size_t(corners[i])];
    Mat3 direction_from_barycentric;
    direction_from_barycentric << points[0], points[1], points[2];
    const double size = points[0].norm() * points[1].norm() * points[2].norm();
    // Edge-on to the projector, or through its centre: no light lands.
    if (!(std::abs(direction_from_barycentric.determinant()) > 1e-15 * size)) continue;
    triangles_.push_back({direction_from_barycentric.inverse(), corners});
    cones.push_back(cone_around(points));
  }
  const ImageSize size = projector.size();
  tiles_across_ = (size.width + kTilePixels - 1) / kTilePixels;
  for (int y = 0; y < size.height; y += kTilePixels)
    for (int x = 0; x < size.width; x += kTilePixels) {
      const Cone tile = cone_of_tile(projector, x, y);
      std::vector<int>& asked = of_tile_.emplace_back();
      for (std::size_t i = 0; i < cones.size(); ++i)
        if (tile.touches(cones[i])) asked.push_back(int(i));
    }
}

std::optional<MeshLight::Hit> MeshLight::hit(const Vec2& pixel) const {
  const std::optional<Ray> ray = projector_.emit(pixel);
  if (!ray) return std::nullopt;
  const int tile = int(pixel.y()) / kTilePixels * tiles_across_ + int(pixel.x()) / kTilePixels;
  double nearest = 0;  // 1 / distance
  std::optional<Hit> hit;
  for (const int index : of_tile_[std::size_t(tile)]) {
    const Triangle& triangle = triangles_[std::size_t(index)];
    const Vec3 b = triangle.barycentric_from_direction * ray->direction;
    const double sum = b.sum();
    if (!(sum > nearest && b.minCoeff() >= -1e-12 * sum)) continue;  // neighbours leave no gap
    nearest = sum;
    Vec2 uv = Vec2::Zero();
    for (int i = 0; i < 3; ++i)
      uv += b[i] / sum * placed_.mesh->uv[std::size_t(triangle.corners[std::size_t(i)])];
    hit = Hit{uv, ray->direction / sum};
  }
  return hit;
}

}  // namespace procam::surface
