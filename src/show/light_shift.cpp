#include "light_shift.hpp"

#include <cmath>

namespace procam::show {

static std::optional<Vec2> content_point(const PlacedPlane& plane, const Vec2& uv) {
  const Vec3 h = plane.plane_from_content * uv.homogeneous();
  if (!(std::abs(h.z()) > 0)) return std::nullopt;
  return Vec2(h.x() / h.z(), h.y() / h.z());
}

std::optional<Vec2> content_centre(const PlacedPlane& plane) {
  return content_point(plane, Vec2(0.5, 0.5));
}

std::optional<Mat3> light_shift(const PlacedPlane& plane, const Pose& world_from_projector,
                                const Mat6& covariance) {
  const std::optional<Vec2> centre = content_centre(plane);
  return centre ? light_shift(plane, *centre, world_from_projector, covariance) : std::nullopt;
}

double mean_square_shift(const PlacedPlane& plane, const Pose& world_from_projector, const Mat6& covariance) {
  double sum = 0;
  for (const Vec2& corner : {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)}) {
    const std::optional<Vec2> point = content_point(plane, corner);
    const std::optional<Mat3> shift =
        point ? light_shift(plane, *point, world_from_projector, covariance) : std::nullopt;
    if (shift) sum += shift->trace();
  }
  return sum / 4;
}

std::optional<Mat3> light_shift(const PlacedPlane& plane, const Vec2& point, const Pose& world_from_projector,
                                const Mat6& covariance) {
  const Vec3 in_projector = plane.projector_from_surface * Vec3(point.x(), point.y(), 0);
  const Vec3 p = world_from_projector * in_projector;
  const Vec3 d = world_from_projector.rotate(in_projector);
  const Vec3 n = world_from_projector.rotate(plane.projector_from_surface.rotate(Vec3::UnitZ()));
  if (!(std::abs(n.dot(d)) > 1e-6 * d.norm())) return std::nullopt;  // edge-on: no light on it
  Eigen::Matrix<double, 3, 6> moved;
  moved << 0, p.z(), -p.y(), 1, 0, 0,  //
      -p.z(), 0, p.x(), 0, 1, 0,       //
      p.y(), -p.x(), 0, 0, 0, 1;
  const Eigen::Matrix<double, 3, 6> shift = (Mat3::Identity() - d * n.transpose() / n.dot(d)) * moved;
  return Mat3(shift * covariance * shift.transpose());
}

}  // namespace procam::show
