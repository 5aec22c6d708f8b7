// Frusta and coordinate frames of MPCDI <-> projectors and poses.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "procam/io/exchange/mpcdi.hpp"

namespace procam::io {
namespace {

/// The picture's edges at distance 1, y upwards.
struct Edges {
  double left, right, down, up;
};

Edges edges_of(const MpcdiFrustum& frustum) {
  return {std::tan(frustum.left * kDegree), std::tan(frustum.right * kDegree),
          std::tan(frustum.down * kDegree), std::tan(frustum.up * kDegree)};
}

/// Ry(yaw) Rx(pitch) Rz(roll), about an optical frame's axes.
Mat3 rotation_of(const MpcdiFrustum& frustum) {
  const auto about = [](double degrees, const Vec3& axis) {
    return Eigen::AngleAxisd(degrees * kDegree, axis);
  };
  return (about(frustum.yaw, Vec3::UnitY()) * about(frustum.pitch, Vec3::UnitX()) *
          about(frustum.roll, Vec3::UnitZ()))
      .toRotationMatrix();
}

/// Near straight up or down yaw and roll are one turn: the yaw takes what the roll was rounded by.
void set_angles(MpcdiFrustum& frustum, const Mat3& r) {
  frustum.yaw = 0;
  frustum.pitch = std::atan2(-r(1, 2), std::hypot(r(1, 0), r(1, 1))) / kDegree;
  frustum.roll = std::atan2(r(1, 0), r(1, 1)) / kDegree;
  const Mat3 about_y = r * rotation_of(frustum).transpose();
  frustum.yaw = std::atan2(about_y(0, 2), about_y(0, 0)) / kDegree;
}

/// Where a pixel's light crosses the plane at distance 1, y upwards.
std::optional<Vec2> crossing(const Projector& projector, const Vec2& pixel) {
  const std::optional<Ray> ray = projector.emit(pixel);
  if (!ray || !(ray->direction.z() > 0)) return std::nullopt;
  return Vec2(ray->direction.x() / ray->direction.z(), -ray->direction.y() / ray->direction.z());
}

/// The box around all light. A lens model is one to one, so the border of the picture bounds it.
Edges edges_of(const Projector& projector) {
  const double inf = std::numeric_limits<double>::infinity();
  Edges edges{inf, -inf, inf, -inf};
  const auto widen = [&](double x, double y) {
    const std::optional<Vec2> at = crossing(projector, Vec2(x - 0.5, y - 0.5));
    if (!at) return;
    edges.left = std::min(edges.left, at->x());
    edges.right = std::max(edges.right, at->x());
    edges.down = std::min(edges.down, at->y());
    edges.up = std::max(edges.up, at->y());
  };
  const ImageSize size = projector.size();
  for (int x = 0; x <= size.width; ++x) {
    widen(x, 0);
    widen(x, size.height);
  }
  for (int y = 0; y <= size.height; ++y) {
    widen(0, y);
    widen(size.width, y);
  }
  return edges;
}

/// For each pixel, where in the frustum's picture its light looks.
WarpMap distortion_map(const Projector& projector, const Edges& edges) {
  WarpMap map{ImageF(projector.size(), 3, 0.0f)};
  for (int y = 0; y < map.content.height(); ++y)
    for (int x = 0; x < map.content.width(); ++x) {
      const std::optional<Vec2> at = crossing(projector, Vec2(x, y));
      if (!at) continue;
      const double u = (at->x() - edges.left) / (edges.right - edges.left);
      const double v = (edges.up - at->y()) / (edges.up - edges.down);
      if (!(u >= 0 && u <= 1 && v >= 0 && v <= 1)) continue;
      map.content.at(x, y, 0) = float(u);
      map.content.at(x, y, 1) = float(v);
      map.content.at(x, y, 2) = 1;
    }
  return map;
}

/// How far a pixel of the frustum alone lies from the lens's, at worst over a grid.
double largest_difference_px(const Projector& projector, const Projector& pinhole) {
  double largest = 0;
  const ImageSize size = projector.size();
  for (int j = 0; j <= 16; ++j)
    for (int i = 0; i <= 16; ++i) {
      const Vec2 pixel(i * (size.width - 1) / 16.0, j * (size.height - 1) / 16.0);
      const std::optional<Ray> ray = projector.emit(pixel);
      const std::optional<Vec2> seen = ray ? pinhole.project(ray->direction) : std::nullopt;
      if (seen) largest = std::max(largest, (*seen - pixel).norm());
    }
  return largest;
}

[[noreturn]] void refuse_region(const MpcdiRegion& region, const std::string& why) {
  throw Error(ErrorKind::kInput, "MPCDI region '" + region.id + "'", why,
              "use a file of the profiles 3d or sl, which say where the projectors stand");
}

}  // namespace

Projector projector_of(const MpcdiRegion& region) {
  if (!region.frustum) refuse_region(region, "it has no frustum");
  const Edges edges = edges_of(*region.frustum);
  const double width = edges.right - edges.left, height = edges.up - edges.down;
  if (!(width > 0 && height > 0 && std::isfinite(width) && std::isfinite(height)))
    refuse_region(region, "its frustum is empty");
  Camera camera;
  camera.size = region.size;
  camera.intrinsics.fx = region.size.width / width;
  camera.intrinsics.fy = region.size.height / height;
  camera.intrinsics.cx = -edges.left * camera.intrinsics.fx - 0.5;
  camera.intrinsics.cy = edges.up * camera.intrinsics.fy - 0.5;
  return {camera};
}

Pose world_from_projector(const MpcdiRegion& region) {
  if (!region.frustum) refuse_region(region, "it has no frustum, and so no direction");
  const MpcdiFrame frame = region.frame.value_or(MpcdiFrame{});
  Mat3 world_from_level;  // of a projector whose angles are zero
  world_from_level << frame.pitch, frame.yaw, frame.roll;
  const Mat3 product = world_from_level.transpose() * world_from_level;
  if (!((product - Mat3::Identity()).cwiseAbs().maxCoeff() < 1e-3))
    refuse_region(region,
                  "its coordinate frame's pitch, yaw and roll are not unit vectors square to each other");
  if (!(frame.pitch.dot(frame.yaw.cross(frame.roll)) > 0))
    throw Error(ErrorKind::kUnsupported, "MPCDI region '" + region.id + "'",
                "its coordinate frame is left-handed", "export it with right-handed axes");
  return Pose(Mat3(Pose(world_from_level, Vec3::Zero()).rotation_matrix() * rotation_of(*region.frustum)),
              frame.position);
}

Diagnostics set_projector(MpcdiRegion& region, const Projector& projector, const Pose& world_from_projector) {
  const Edges edges = edges_of(projector);
  require(edges.right > edges.left && edges.up > edges.down,
          "set_projector: no pixel of the projector sends light forwards");
  region.size = projector.size();
  region.frustum = MpcdiFrustum{};
  region.frustum->left = std::atan(edges.left) / kDegree;
  region.frustum->right = std::atan(edges.right) / kDegree;
  region.frustum->down = std::atan(edges.down) / kDegree;
  region.frustum->up = std::atan(edges.up) / kDegree;
  region.frame = MpcdiFrame{};
  region.frame->position = world_from_projector.translation;
  Mat3 world_from_level;
  world_from_level << region.frame->pitch, region.frame->yaw, region.frame->roll;
  set_angles(*region.frustum, world_from_level.transpose() * world_from_projector.rotation_matrix());
  region.distortion = distortion_map(projector, edges);

  Diagnostics diagnostics;
  const double off = largest_difference_px(projector, projector_of(region));
  if (off > 1e-6) {
    char pixels[32];
    std::snprintf(pixels, sizeof pixels, "%.2g", off);
    diagnostics.warn("frustum_is_not_lens",
                     "the frustum of '" + region.id +
                         "' carries neither skew nor distortion: alone it puts "
                         "pixels up to " +
                         std::string(pixels) +
                         " px off; the distortion map has the rest: use a reader that applies it");
  }
  return diagnostics;
}

}  // namespace procam::io
