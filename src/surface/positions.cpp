#include "positions.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <limits>

#include "mesh_light.hpp"
#include "procam/core/base/parallel.hpp"

namespace procam::surface {
namespace {

/// Pixels 0, step, 2 step ... and the last one.
int node_count(int pixels, int step) {
  return (pixels + step - 2) / step + 1;
}

void put(const Vec3& vector, float* pixel) {
  for (int c = 0; c < 3; ++c) pixel[c] = float(vector[c]);
}

template <typename Place>
void each_position(ImageF& map, int threads, const Place& place) {
  parallel_for(map.height(), threads, [&](int begin, int end) {
    for (int y = begin; y < end; ++y)
      for (int x = 0; x < map.width(); ++x) place(x, y, map.row(y) + 3 * std::ptrdiff_t(x));
  });
}

void fill(const ImageF& directions, const PlacedPlane& placed, const Projector&, int threads, ImageF& map) {
  const Mat3 rotation = placed.projector_from_surface.rotation_matrix();
  const Vec3 normal = rotation.col(2), origin = placed.projector_from_surface.translation;
  const double distance = normal.dot(origin);
  Mat3 direction_from_plane = rotation;
  direction_from_plane.col(2) = origin;
  const Mat3 direction_from_content = direction_from_plane * placed.plane_from_content;
  const double scale = direction_from_content.norm(), determinant = direction_from_content.determinant();
  if (!(std::abs(determinant) > 1e-15 * scale * scale * scale)) return;  // a plane through the projector
  Mat3 content_from_direction = direction_from_content.inverse();
  content_from_direction /= content_from_direction.norm();
  each_position(map, threads, [&](int x, int y, float* position) {
    const Vec3 direction =
        Eigen::Map<const Eigen::Vector3f>(directions.row(y) + 3 * std::ptrdiff_t(x)).cast<double>();
    const Vec3 q = content_from_direction * direction;
    if (!(q.z() > 0 && q.x() >= 0 && q.y() >= 0 && q.x() <= q.z() && q.y() <= q.z())) return;  // NaN too
    put(distance / normal.dot(direction) * direction, position);
  });
}

void fill(const ImageF&, const PlacedMesh& placed, const Projector& projector, int threads, ImageF& map) {
  const MeshLight light(projector, placed);
  each_position(map, threads, [&](int x, int y, float* position) {
    const std::optional<MeshLight::Hit> hit = light.hit(Vec2(x, y));
    if (hit && hit->uv.minCoeff() >= 0 && hit->uv.maxCoeff() <= 1) put(hit->point_in_projector, position);
  });
}

void fill(const ImageF&, const PlacedPixels&, const Projector&, int, ImageF&) {}

}  // namespace

ImageF light_directions(const Projector& projector, int threads) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  const ImageSize size = projector.size();
  const int step = std::max(1, size.width / 480);
  ImageF nodes(node_count(size.width, step), node_count(size.height, step), 3, kNone);
  each_position(nodes, threads, [&](int i, int j, float* node) {
    if (const auto ray =
            projector.emit(Vec2(std::min(i * step, size.width - 1), std::min(j * step, size.height - 1))))
      put(ray->direction, node);
  });
  if (step == 1) return nodes;
  ImageF directions(size, 3, kNone);
  each_position(directions, threads, [&](int x, int y, float* direction) {
    const int i = std::min(x / step, nodes.width() - 2), j = std::min(y / step, nodes.height() - 2);
    const int width = std::min((i + 1) * step, size.width - 1) - i * step,
              height = std::min((j + 1) * step, size.height - 1) - j * step;
    const float s = float(x - i * step) / float(width), t = float(y - j * step) / float(height);
    const float *above = nodes.row(j) + 3 * std::ptrdiff_t(i),
                *below = nodes.row(j + 1) + 3 * std::ptrdiff_t(i);
    for (int c = 0; c < 3; ++c)
      direction[c] =
          (1 - t) * ((1 - s) * above[c] + s * above[c + 3]) + t * ((1 - s) * below[c] + s * below[c + 3]);
    if (direction[0] == direction[0]) return;
    if (const auto ray = projector.emit(Vec2(x, y)))
      put(ray->direction, direction);  // at the border of the lens model
  });
  return directions;
}

ImageF positions_along(const ImageF& directions, const Placement& placement, const Projector& projector,
                       int threads) {
  ImageF map(projector.size(), 3, std::numeric_limits<float>::quiet_NaN());
  std::visit([&](const auto& placed) { fill(directions, placed, projector, threads, map); }, placement);
  return map;
}

}  // namespace procam::surface
