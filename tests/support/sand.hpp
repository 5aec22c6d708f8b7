#pragma once
/// A box of uneven sand before a depth camera, for tests of live shapes.
#include <cmath>
#include <memory>

#include "procam/core/geometry/se3.hpp"
#include "procam/simulate/depth_view.hpp"

namespace procam::test {

/// Bumps of several widths, metres over the ground, moved along x by `shift`.
inline double sand(double x, double y, double shift) {
  x -= shift;
  return 0.022 * std::sin(9.1 * x + 1.3) * std::cos(7.3 * y + 0.4) + 0.015 * std::sin(17 * y + 5 * x) +
         0.02 * std::exp(-((x - 0.4) * (x - 0.4) + (y - 0.35) * (y - 0.35)) / (2 * 0.06 * 0.06));
}

inline constexpr double kHandRadius = 0.05;

struct SandBox {
  double distance = 1;
  simulate::DepthSensor sensor;
  Pose room_from_camera;  ///< the room's x right, y down, z away; sand at z = -height
  double wide = 1.3;

  explicit SandBox(double metres) : distance(metres) {
    sensor.camera = {{640, 480}, {585, 581, 316.2, 243.7, 0.3}, NoDistortion{}};
    wide = 1.3 * metres;
    room_from_camera = Pose(so3_exp(Vec3(0.06, -0.05, 0.02)), Vec3(0.02, -0.01, -metres));
  }
  simulate::Room room(double shift, double rise) const {
    constexpr int kSide = 160;
    auto mesh = std::make_shared<Mesh>();
    for (int j = 0; j <= kSide; ++j)
      for (int i = 0; i <= kSide; ++i) {
        const double x = wide * (double(i) / kSide - 0.5), y = wide * (double(j) / kSide - 0.5);
        mesh->vertices.emplace_back(x, y, -sand(x, y, shift) - rise);
        mesh->uv.emplace_back(double(i) / kSide, double(j) / kSide);
      }
    for (int j = 0; j < kSide; ++j)
      for (int i = 0; i < kSide; ++i) {
        const int a = j * (kSide + 1) + i, d = a + kSide + 1;
        mesh->triangles.push_back({a, a + 1, d + 1});
        mesh->triangles.push_back({a, d + 1, d});
      }
    simulate::Room made;
    made.bodies.push_back({"sand", simulate::TriangleMesh(mesh), Pose()});
    return made;
  }
  /// The room and a hand's ball above it, its middle `above` metres over the ground.
  static simulate::Room with_hand(simulate::Room now, const Vec2& place, double above) {
    now.bodies.push_back({"hand", simulate::Sphere{kHandRadius},
                          Pose(Eigen::Quaterniond::Identity(), Vec3(place.x(), place.y(), -above))});
    return now;
  }
  simulate::DepthView view(const simulate::Room& now, std::uint64_t seed) const {
    return simulate::depth_view(now, sensor, room_from_camera, seed, 2);
  }
  Image<std::uint16_t> seen(const simulate::Room& now, std::uint64_t seed) const {
    return view(now, seed).mm;
  }
};

}  // namespace procam::test
