#pragma once
/// Curved surfaces before a lopsided projector, and what tells where light lands on them.
#include <vector>

#include "render/rooms.hpp"

namespace procam {

/// Small discs of light on black: the middle of a disc's light is that of the disc to a few hundredths of a
/// millimetre, however the surface is bent under it.
struct Discs {
  std::vector<Vec2> uv{{0.12, 0.16}, {0.87, 0.11}, {0.46, 0.53}, {0.91, 0.84}, {0.19, 0.79}};
  ImageU8 picture{1600, 1200, 1};

  Discs() {
    for (int y = 0; y < 1200; ++y)
      for (int x = 0; x < 1600; ++x)
        for (const Vec2& place : uv)
          if (std::hypot(x + 0.5 - 1600 * place.x(), y + 0.5 - 1200 * place.y()) < 12) picture.at(x, y) = 255;
  }
};

/// Middle of the light in a window round a pixel.
inline Vec2 middle_of_light(const ImageU8& frame, const Vec2& near, int reach) {
  Vec2 sum = Vec2::Zero();
  double weight = 0;
  for (int y = int(near.y()) - reach; y <= int(near.y()) + reach; ++y)
    for (int x = int(near.x()) - reach; x <= int(near.x()) + reach; ++x) {
      if (x < 0 || y < 0 || x >= frame.width() || y >= frame.height()) continue;
      sum += light_of(frame.at(x, y)) * Vec2(x, y);
      weight += light_of(frame.at(x, y));
    }
  return sum / weight;
}

/// First meeting of a ray with the ball or tube x^2 + (y^2) + z^2 = r^2 that `wanted` picks (near or far).
inline Vec3 on_quadric(const Ray& ray, double radius, bool ball, bool far) {
  const Vec3 keep(1, ball ? 1 : 0, 1);
  const Vec3 o = ray.origin.cwiseProduct(keep), d = ray.direction.cwiseProduct(keep);
  const double a = d.squaredNorm(), b = o.dot(d), c = o.squaredNorm() - radius * radius;
  const double root = std::sqrt(b * b - a * c);
  return ray.at((-b + (far ? root : -root)) / a);
}

struct Shaped {
  const char* name;
  SurfaceGeometry geometry;
  Pose projector_from_surface;
};

inline std::vector<Shaped> shaped() {
  const Projector projector = lopsided_projector();
  const Vec3 axis = projector.emit(Vec2(520, 371))->direction;
  const auto turned = [](double x, double y, double z) {
    return Mat3((Eigen::AngleAxisd(x, Vec3::UnitX()) * Eigen::AngleAxisd(y, Vec3::UnitY()) *
                 Eigen::AngleAxisd(z, Vec3::UnitZ()))
                    .toRotationMatrix());
  };
  CylinderSurface column;
  column.radius = 0.31;
  column.left = -0.9;
  column.right = 0.7;
  column.top = -0.21;
  column.bottom = 0.24;
  CylinderSurface niche = column;
  niche.radius = 0.8;
  niche.left = -0.4;
  niche.right = 0.3;
  niche.seen_from = SeenFrom::kInside;
  SphereSurface globe;
  globe.radius = 0.27;
  globe.left = -0.8;
  globe.right = 0.9;
  globe.top = 0.7;
  globe.bottom = -0.6;
  SphereSurface dome = globe;
  dome.radius = 0.9;
  dome.left = -0.35;
  dome.right = 0.3;
  dome.top = 0.25;
  dome.bottom = -0.3;
  dome.seen_from = SeenFrom::kInside;
  // The content's middle lies on that ray.
  const auto placed = [&](const auto& shape, const Mat3& rotation, double distance) {
    return Pose(rotation, distance * axis - rotation * shape.point({0.5, 0.5}));
  };
  return {{"column", column, placed(column, turned(0.2, -0.15, 0.1), 1.7)},
          {"niche", niche, placed(niche, turned(-0.1, 0.2, -0.12), 2.1)},
          {"globe", globe, placed(globe, turned(0.3, 0.1, 0.2), 1.6)},
          {"dome", dome, placed(dome, turned(0.2, -0.2, 0.1), 1.9)}};
}

}  // namespace procam
