#pragma once
/// What the tests of calibrate_room() share beside the numeric world.
#include <cmath>

#include "numeric_room.hpp"
#include "procam/room/calibrate_room.hpp"

namespace procam::test {

inline room::RoomOptions known_cameras(const NumericWorld& world) {
  room::RoomOptions options;
  for (int c = 0; c < int(world.cameras.size()); ++c)
    options.cameras[numeric_camera_name(world, c)] = {world.cameras[std::size_t(c)], {}, 0.0};
  options.threads = 2;
  return options;
}

/// Two points that the first position sees of the first projector's light, far apart, and their true distance; known
/// to half a millimetre.
inline room::KnownDistance wall_distance(const NumericWorld& world, const room::RoomPoints& points) {
  int left = -1, right = -1;
  for (int i = 0; i < int(points.points.size()); ++i) {
    const room::LightReading& anchor = points.points[std::size_t(i)].readings[0];
    if (anchor.map != 0 || std::abs(anchor.camera_pixel.y() - 480) > 200) continue;
    const auto light = world.light(0, world.maps[0].second, anchor.camera_pixel);
    if (!light || (*light - anchor.projector_pixel).norm() > 0.5) continue;  // a wrong one
    const auto x = [&](int k) { return points.points[std::size_t(k)].readings[0].camera_pixel.x(); };
    if (left < 0 || x(i) < x(left)) left = i;
    if (right < 0 || x(i) > x(right)) right = i;
  }
  const auto at = [&](int i) {
    return *world.seen(0, points.points[std::size_t(i)].readings[0].camera_pixel);
  };
  return {{left, right}, {}, (at(left) - at(right)).norm(), 5e-4};
}

/// RMS of the depths that the solved rig gives the exact light of the first map, metres.
inline double wall_error(const NumericWorld& world, const Rig& rig) {
  double sum = 0;
  int count = 0;
  const RigCamera& camera = rig.cameras[0];
  const RigProjector& projector = rig.projectors[0];
  const Pose projector_from_camera = projector.rig_from_projector.inverse() * camera.rig_from_camera;
  for (int y = 30; y < 960; y += 60)
    for (int x = 30; x < 1280; x += 60) {
      const auto light = world.light(0, 0, Vec2(x, y));
      if (!light) continue;
      const Vec3 truth = *world.seen(0, Vec2(x, y));
      const auto d = camera.camera.unproject(Vec2(x, y)),
                 e = projector.projector.inverse_camera.unproject(*light);
      if (!d || !e) continue;
      const Vec3 a = e->cross(projector_from_camera.rotation * *d),
                 b = e->cross(projector_from_camera.translation);
      const double range = -a.dot(b) / a.squaredNorm();
      sum += std::pow(range - truth.norm(), 2);
      ++count;
    }
  return std::sqrt(sum / std::max(1, count));
}

}  // namespace procam::test
