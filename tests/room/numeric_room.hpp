#pragma once
/// Rooms of planes and spheres, a rig, and the light that its cameras read in them, without images: truth for
/// calibrate_room().
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "procam/core/base/closed_form.hpp"
#include "procam/core/geometry/plane.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/room/points.hpp"

namespace procam::test {

struct NumericBall {
  Vec3 centre;
  double radius;
};

/// The first thing that a ray meets.
struct NumericRoom {
  std::vector<Plane> planes;
  std::vector<NumericBall> balls;

  std::optional<Vec3> hit(const Vec3& from, const Vec3& direction) const {
    double nearest = 1e9;
    for (const Plane& plane : planes) {
      const double t = -(plane.offset + plane.normal.dot(from)) / plane.normal.dot(direction);
      if (t > 1e-6 && t < nearest) nearest = t;
    }
    for (const NumericBall& ball : balls) {
      const Vec3 o = from - ball.centre;
      const double a = direction.squaredNorm(), b = o.dot(direction),
                   c = o.squaredNorm() - ball.radius * ball.radius;
      const double root = b * b - a * c;
      if (root <= 0) continue;
      const double t = (-b - std::sqrt(root)) / a;
      if (t > 1e-6 && t < nearest) nearest = t;
    }
    if (nearest > 1e8) return std::nullopt;
    return Vec3(from + nearest * direction);
  }
};

inline Plane plane_through(const Vec3& point, const Vec3& normal) {
  return {normal.normalized(), -normal.normalized().dot(point)};
}

/// Two walls that meet, a floor, and a ball before them.
inline NumericRoom corner_room() {
  return {
      {plane_through({0.1, 0, 2.3}, {0.6, 0.05, -0.8}), plane_through({0.1, 0, 2.3}, {-0.75, 0.02, -0.66}),
       plane_through({0, 0.75, 0}, {0.03, -1, -0.02})},
      {{{0.15, 0.2, 1.7}, 0.25}}};
}
inline NumericRoom flat_room() {
  return {{plane_through({0, 0, 2}, {0.25, 0.1, -1})}, {}};
}

/// A device somewhere that looks at a point.
inline Pose looking_at(const Vec3& from, const Vec3& at, double roll) {
  const Vec3 z = (at - from).normalized(), x = Vec3::UnitY().cross(z).normalized();
  Mat3 axes;
  axes << x, z.cross(x), z;
  return Pose(Eigen::Quaterniond(axes) * so3_exp(Vec3(0, 0, roll)), from);
}

/// Skewed, distorted lenses, no two alike. The projector's axis is far from the middle of its picture.
inline Camera numeric_camera(int which) {
  const double z = 1 + 0.03 * which;
  return {{1280, 960},
          {1052 * z, 1047 * z, 633.0 - 5 * which, 491.0 + 3 * which, 1.7},
          BrownConrady{{0.06, -0.12, 0.001, -0.0007, 0.02}}};
}
inline Camera numeric_projector(int which) {
  const double z = 1 + 0.05 * which;
  return {{1024, 768},
          {1710 * z, 1704 * z, 611.0 + 8 * which, 696.0 - 20 * which, -1.4},
          BrownConrady{{-0.05, 0.03, 0.0006, 0.0008, -0.02}}};
}

struct NumericPosition {
  int camera;
  std::string view;
  Pose rig_from_camera;
};

struct NumericWorld {
  NumericRoom room;
  std::vector<Camera> cameras;
  std::vector<NumericPosition> positions;
  std::vector<RigProjector> projectors;
  std::vector<std::pair<int, int>> maps;  ///< position and projector

  /// The projector's pixel that lights what the position sees at a pixel.
  std::optional<Vec2> light(int position, int projector, const Vec2& pixel) const {
    const NumericPosition& p = positions[std::size_t(position)];
    const auto bearing = cameras[std::size_t(p.camera)].unproject(pixel);
    if (!bearing) return std::nullopt;
    const auto at = room.hit(p.rig_from_camera.translation, p.rig_from_camera.rotation * *bearing);
    if (!at) return std::nullopt;
    return lit(projector, *at);
  }
  std::optional<Vec2> lit(int projector, const Vec3& at) const {
    const RigProjector& device = projectors[std::size_t(projector)];
    const Vec3 from = device.rig_from_projector.translation;
    const auto first = room.hit(from, at - from);
    if (!first || (*first - at).norm() > 1e-6) return std::nullopt;
    const auto pixel = device.projector.project(device.rig_from_projector.inverse() * at);
    if (!pixel || !device.projector.size().contains(*pixel)) return std::nullopt;
    return pixel;
  }
  std::optional<Vec3> seen(int position, const Vec2& pixel) const {
    const NumericPosition& p = positions[std::size_t(position)];
    const auto bearing = cameras[std::size_t(p.camera)].unproject(pixel);
    if (!bearing) return std::nullopt;
    return room.hit(p.rig_from_camera.translation, p.rig_from_camera.rotation * *bearing);
  }
};

/// One camera position after the other around a corner; `projectors` beside them. Every position sees every
/// projector.
inline NumericWorld numeric_world(int cameras, int positions_each, int projectors,
                                  NumericRoom room = corner_room()) {
  NumericWorld world;
  world.room = std::move(room);
  for (int c = 0; c < cameras; ++c) world.cameras.push_back(numeric_camera(c));
  const Vec3 middle(0.08, 0.05, 2.0);
  const Vec3 places[] = {{0, 0, 0},         {-0.45, -0.2, 0.1}, {0.5, 0.15, -0.1}, {0.1, -0.5, 0.05},
                         {-0.6, 0.25, 0.2}, {0.7, -0.3, 0.1},   {-0.2, 0.35, 0.0}, {0.3, -0.15, 0.25}};
  const Pose first = looking_at(places[0], middle, 0.02);
  int at = 0;
  for (int v = 0; v < positions_each; ++v)
    for (int c = 0; c < cameras; ++c, ++at) {
      const Pose pose = looking_at(places[at % 8], middle + 0.03 * Vec3(at % 3, at % 2, 0), 0.05 * at - 0.04);
      world.positions.push_back(
          {c, "view_0" + std::to_string(v), first.inverse() * (at == 0 ? first : pose)});
    }
  for (int p = 0; p < projectors; ++p) {
    RigProjector projector;
    projector.name = projectors == 1 ? "projector" : "projector" + std::to_string(p + 1);
    projector.projector.inverse_camera = numeric_projector(p);
    const Vec3 from(0.32 - 0.65 * (p % 2) + 0.2 * (p / 2), 0.22 - 0.1 * p, -0.12 + 0.07 * p);
    // The middle of its picture falls on the middle of the room.
    Pose pose = looking_at(from, middle, 0.03 * p - 0.05);
    const Vec3 centre = *projector.projector.inverse_camera.unproject(Vec2(511.5, 383.5));
    pose.rotation = pose.rotation * rotation_between(centre, Vec3::UnitZ());
    projector.rig_from_projector = first.inverse() * pose;
    world.projectors.push_back(projector);
  }
  NumericRoom moved;  // everything in the first position's frame
  const Pose rig_from_room = first.inverse();
  for (const Plane& plane : world.room.planes)
    moved.planes.push_back(plane_through(rig_from_room * Vec3(-plane.offset * plane.normal),
                                         rig_from_room.rotation * plane.normal));
  for (const NumericBall& ball : world.room.balls)
    moved.balls.push_back({rig_from_room * ball.centre, ball.radius});
  world.room = moved;
  for (int i = 0; i < int(world.positions.size()); ++i)
    for (int p = 0; p < projectors; ++p) world.maps.emplace_back(i, p);
  return world;
}

inline std::string numeric_camera_name(const NumericWorld& world, int camera) {
  return world.cameras.size() == 1 ? "camera" : "camera" + std::to_string(camera + 1);
}

/// The light's derivative by the camera's pixel; nullopt beside an edge.
inline std::optional<Mat2> light_by_pixel(const NumericWorld& world, int position, int projector,
                                          const Vec2& at) {
  constexpr double kStep = 1.5;
  Mat2 j;
  const auto middle = world.light(position, projector, at);
  if (!middle) return std::nullopt;
  for (int c = 0; c < 2; ++c) {
    const Vec2 step = kStep * Vec2::Unit(c);
    const auto up = world.light(position, projector, at + step),
               down = world.light(position, projector, at - step);
    if (!up || !down || (*up + *down - 2 * *middle).norm() > 0.05) return std::nullopt;
    j.col(c) = (*up - *down) / (2 * kStep);
  }
  return j;
}

struct NumericNoise {
  double sigma = 0.05;  ///< projector pixels, both coordinates
  double wrong = 0;     ///< share of readings that are off by 2 to 40 pixels
  unsigned seed = 1;
};

inline room::RoomPoints read_points(const NumericWorld& world, int step, const NumericNoise& noise) {
  room::RoomPoints out;
  for (int c = 0; c < int(world.cameras.size()); ++c)
    out.cameras.push_back(
        {numeric_camera_name(world, c), DeviceKind::kCamera, world.cameras[std::size_t(c)].size});
  for (const RigProjector& projector : world.projectors)
    out.projectors.push_back({projector.name, DeviceKind::kProjector, projector.projector.size()});
  for (const NumericPosition& p : world.positions) out.positions.push_back({p.camera, p.view});
  for (const auto& [position, projector] : world.maps) out.maps.push_back({position, projector});
  std::mt19937 random(noise.seed);
  std::normal_distribution<double> normal(0, noise.sigma);
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto reading = [&](int map, const Vec2& at) -> std::optional<room::LightReading> {
    const auto& [position, projector] = world.maps[std::size_t(map)];
    const auto pixel = world.light(position, projector, at);
    const auto by = light_by_pixel(world, position, projector, at);
    if (!pixel || !by) return std::nullopt;
    Vec2 p = *pixel;
    for (int c = 0; c < 2; ++c) p[c] += normal(random);
    if (uniform(random) < noise.wrong)
      p[uniform(random) < 0.5] += (2 + 38 * uniform(random)) * (uniform(random) < 0.5 ? -1 : 1);
    return room::LightReading{map, at, p, *by, Vec2::Constant(noise.sigma > 0 ? noise.sigma : 0.05)};
  };
  for (int map = 0; map < int(world.maps.size()); ++map) {
    const auto& [position, projector] = world.maps[std::size_t(map)];
    const Camera& camera = world.cameras[std::size_t(world.positions[std::size_t(position)].camera)];
    for (int y = step / 2; y < camera.size.height; y += step)
      for (int x = step / 2; x < camera.size.width; x += step) {
        const auto anchor = reading(map, Vec2(x, y));
        if (!anchor) continue;
        room::RoomPoint point{{*anchor}};
        const Vec3 at = *world.seen(position, Vec2(x, y));
        for (int other = 0; other < int(world.maps.size()); ++other) {
          const auto& [to, by] = world.maps[std::size_t(other)];
          if (other == map || (to != position && by != projector)) continue;
          Vec2 pixel(x, y);
          if (to != position) {
            const NumericPosition& p = world.positions[std::size_t(to)];
            const Camera& lens = world.cameras[std::size_t(p.camera)];
            const auto image = lens.project(p.rig_from_camera.inverse() * at);
            if (!image || !lens.size.contains(*image)) continue;
            const auto back = world.seen(to, *image);
            if (!back || (*back - at).norm() > 1e-6) continue;
            pixel = Vec2(std::round(image->x()), std::round(image->y()));
          }
          if (const auto more = reading(other, pixel)) point.readings.push_back(*more);
        }
        out.points.push_back(std::move(point));
      }
  }
  return out;
}

}  // namespace procam::test
