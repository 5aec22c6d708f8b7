#include "procam/depth/room_depth.hpp"

#include <algorithm>
#include <cmath>

namespace procam::depth {
namespace {

constexpr int kRayBlock = 4;  ///< pixels a side that share planes

/// A plane before the camera, and where on it the room goes on.
struct KnownPlane {
  Vec3 x, y, n, t;  ///< axes, normal (away from the camera) and origin in the camera's frame
  Vec2 low = Vec2::Zero();
  double cell = 0.1;
  ImageU8 known;  ///< coarse cells

  /// Does the ray meet it where it is known?
  bool has(double u, double v) const {
    const Vec3 ray(u, v, 1);
    const double along = n.dot(ray);
    if (!(along > 1e-6)) return false;
    const Vec3 from = n.dot(t) / along * ray - t;
    const double i = (x.dot(from) - low.x()) / cell, j = (y.dot(from) - low.y()) / cell;
    return i >= 0 && j >= 0 && i < known.width() && j < known.height() && known.at(int(i), int(j)) != 0;
  }
};

std::optional<KnownPlane> known_plane(const MapPlane& plane, const Pose& camera_from_world,
                                      const RoomDepthOptions& options) {
  if (plane.name.empty()) return std::nullopt;
  const Pose camera_from_plane = camera_from_world * plane.world_from_plane;
  const Mat3 r = camera_from_plane.rotation_matrix();
  KnownPlane out;
  out.x = r.col(0), out.y = r.col(1), out.n = r.col(2), out.t = camera_from_plane.translation;
  if (!(out.n.dot(out.t) > 0)) return std::nullopt;  // from behind it is another's wall
  // Cells as large as the rim; each spreads to its neighbours.
  const int step = std::max(1, int(std::lround(options.rim / plane.raster.cell)));
  const int width = (plane.free_share.width() + step - 1) / step + 2,
            height = (plane.free_share.height() + step - 1) / step + 2;
  out.cell = step * plane.raster.cell;
  out.low = plane.raster.low - Vec2::Constant(out.cell);
  ImageU8 seen(width, height);
  out.known = ImageU8(width, height);
  long count = 0;
  for (int j = 0; j < plane.free_share.height(); ++j)
    for (int i = 0; i < plane.free_share.width(); ++i)
      if (plane.free_share.at(i, j) >= 0) {
        ++count;
        seen.at(i / step + 1, j / step + 1) = 1;
      }
  const bool is_upright =
      plane.kind == PlaneKind::kWall || plane.kind == PlaneKind::kSlope || plane.kind == PlaneKind::kUnknown;
  const double area = double(count) * plane.raster.cell * plane.raster.cell;
  if (area < (is_upright ? options.min_wall : options.min_level)) return std::nullopt;
  for (int j = 0; j < height; ++j)
    for (int i = 0; i < width; ++i)
      if (seen.at(i, j) != 0)
        for (int b = std::max(j - 1, 0); b <= std::min(j + 1, height - 1); ++b)
          for (int a = std::max(i - 1, 0); a <= std::min(i + 1, width - 1); ++a) out.known.at(a, b) = 1;
  return out;
}

}  // namespace

ImageF room_depth(const PlaneMap& map, const DepthImage& image, const RayTable& rays,
                  const Pose& world_from_camera, const RoomDepthOptions& options) {
  require(image.size() == rays.size(), "room_depth: the image is not of the camera's size");
  require(options.within >= 0 && options.min_wall >= 0 && options.min_level >= 0 && options.rim >= 0,
          "room_depth: lengths and areas must not be negative");
  const Pose camera_from_world = world_from_camera.inverse();
  std::vector<KnownPlane> planes;
  for (const MapPlane& plane : map.planes())
    if (auto known = known_plane(plane, camera_from_world, options)) planes.push_back(std::move(*known));
  const int width = rays.size().width, height = rays.size().height;
  const float within = float(options.within);
  ImageF depth(width, height);
  struct OnRay {
    float nx, ny, nz, offset;
  };
  std::vector<OnRay> here;
  for (int y = 0; y < height; y += kRayBlock)
    for (int x = 0; x < width; x += kRayBlock) {
      const int right = std::min(x + kRayBlock, width), bottom = std::min(y + kRayBlock, height);
      const int mx = std::min(x + kRayBlock / 2, width - 1), my = std::min(y + kRayBlock / 2, height - 1);
      here.clear();
      for (const KnownPlane& plane : planes)
        if (plane.has(double(rays.u(mx, my)), double(rays.v(mx, my))))
          here.push_back(
              {float(plane.n.x()), float(plane.n.y()), float(plane.n.z()), float(plane.n.dot(plane.t))});
      if (here.empty()) continue;
      for (int j = y; j < bottom; ++j)
        for (int i = x; i < right; ++i) {
          const float read = image.at(i, j);
          float farthest = 0, own = 0;
          for (const OnRay& plane : here) {
            const float along = plane.nx * rays.u(i, j) + plane.ny * rays.v(i, j) + plane.nz;
            const float z = along > 1e-6f ? plane.offset / along : 0.0f;
            farthest = std::max(farthest, z);
            if (read > 0 && std::abs(z - read) < within) own = std::max(own, z);
          }
          depth.at(i, j) = own > 0 ? own : farthest;
        }
    }
  return depth;
}

}  // namespace procam::depth
