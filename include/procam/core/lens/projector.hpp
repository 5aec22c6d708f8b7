#pragma once
/// A projector: an inverse camera. Light leaves a pixel, passes the lens outwards and lands on something.
///
/// The lens model is that of a camera standing in the projector's place (`inverse_camera`), so that
/// calibration, files and renderers share one formula; the verbs here follow the light.
#include "procam/core/geometry/plane.hpp"
#include "procam/core/lens/camera.hpp"

namespace procam {

struct Projector {
  Camera inverse_camera;

  ImageSize size() const { return inverse_camera.size; }

  /// The ray of light that leaves a pixel, in the projector's frame, unit direction.
  std::optional<Ray> emit(const Vec2& pixel) const {
    const std::optional<Vec3> bearing = inverse_camera.unproject(pixel);
    if (!bearing) return std::nullopt;
    return Ray{Vec3::Zero(), *bearing};
  }

  /// Where the light of a pixel lands on a plane (both in the projector's frame); nullopt when it misses.
  std::optional<Vec3> intersect(const Vec2& pixel, const Plane& plane_in_projector) const {
    const std::optional<Ray> ray = emit(pixel);
    if (!ray) return std::nullopt;
    return procam::intersect(*ray, plane_in_projector);
  }

  /// The pixel whose light passes through a point (it may lie outside the picture).
  std::optional<Vec2> project(const Vec3& point_in_projector) const {
    return inverse_camera.project(point_in_projector);
  }

  /// Distance over picture width on a screen across the axis, as on a data sheet (without lens
  /// distortion): fx / W.
  double throw_ratio() const { return inverse_camera.intrinsics.fx / size().width; }

  /// How far the optical axis lies from the picture's centre, in picture widths and heights (x right, y down
  /// positive). (0, 0.5): the axis passes the bottom edge, the common table-top projector.
  Vec2 lens_shift() const {
    const Intrinsics& k = inverse_camera.intrinsics;
    return Vec2((k.cx - 0.5 * (size().width - 1)) / size().width,
                (k.cy - 0.5 * (size().height - 1)) / size().height);
  }
};

}  // namespace procam
