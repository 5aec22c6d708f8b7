#pragma once
/// A lopsided projector and tilted sheets in front of it.
#include <cmath>

#include "procam/core/lens/projector.hpp"
#include "procam/core/surface/scene.hpp"
#include "procam/render/cpu.hpp"

namespace procam {

inline double radians(double degrees) {
  return degrees * std::acos(-1.0) / 180;
}

inline render::RenderOptions options(bool linear_light, int threads) {
  render::RenderOptions chosen;
  chosen.linear_light = linear_light;
  chosen.threads = threads;
  return chosen;
}

/// Skewed, off-centre, its optical axis below the picture, as table-top projectors are.
inline Projector lopsided_projector(Distortion distortion = NoDistortion{}) {
  return {Camera{{1024, 768}, {1880, 1846, 497.3, 851.6, 3.1}, distortion}};
}

inline Distortion brown(double k1) {
  return BrownConrady{{k1, 0.03, 0.0011, -0.0007, 0}};
}

/// A sheet of content, metres, met by the ray of a pixel at its middle.
struct Sheet {
  double width, height;
  PlacedPlane placement;

  Vec2 plane_point(double u, double v) const {
    return (placement.plane_from_content * Vec3(u, v, 1)).hnormalized();
  }
  Vec3 in_projector(double u, double v) const {
    const Vec2 p = plane_point(u, v);
    return placement.projector_from_surface * Vec3(p.x(), p.y(), 0);
  }
  /// Where the light of a pixel lands, in the sheet's plane, metres.
  std::optional<Vec2> landed(const Projector& projector, const Vec2& pixel) const {
    const auto point = projector.intersect(pixel, Plane::of_xy(placement.projector_from_surface));
    if (!point) return std::nullopt;
    return Vec2((placement.projector_from_surface.inverse() * *point).head<2>());
  }
};

/// `incidence_deg` between the middle pixel's ray and the sheet's normal, `distance` along that ray; tilted
/// about an oblique axis, turned in its own plane, its origin off its middle.
inline Sheet tilted_sheet(const Projector& projector, double width, double height, double distance,
                          double incidence_deg, const Vec2& middle = Vec2(540, 361)) {
  const Vec3 ray = projector.emit(middle)->direction;
  const Vec3 sideways = Vec3(ray.cross(Vec3(0.35, 1, 0.1))).normalized();
  const Vec3 into_wall = Eigen::AngleAxisd(radians(incidence_deg), sideways) * ray;
  const Vec3 right =
      Eigen::AngleAxisd(radians(6.5), into_wall) * Vec3(Vec3::UnitY().cross(into_wall).normalized());
  Mat3 rotation;
  rotation << right, into_wall.cross(right), into_wall;
  Sheet sheet{width, height, {}};
  sheet.placement.plane_from_content << width, 0, -0.4 * width, 0, height, -0.55 * height, 0, 0, 1;
  const Vec2 p = sheet.plane_point(0.5, 0.5);
  sheet.placement.projector_from_surface = Pose(rotation, distance * ray - rotation * Vec3(p.x(), p.y(), 0));
  return sheet;
}

/// So many pixels inside the picture's border.
struct PixelMargin {
  double px;
  bool holds(ImageSize size, const Vec2& pixel) const {
    return pixel.x() >= px && pixel.y() >= px && pixel.x() <= size.width - 1 - px &&
           pixel.y() <= size.height - 1 - px;
  }
};

/// sRGB value -> light, 0..1 (IEC 61966-2-1).
inline double light_of(double value) {
  const double v = value / 255;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

}  // namespace procam
