#include <algorithm>
#include <cmath>

#include "draw.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/simulate/mount_drive.hpp"

namespace procam::simulate {
namespace {

constexpr double kHigh = 2.6, kLong = 16;  // m: of a wall; its ends are behind the next one

/// x along the wall, y down, z into it; the origin where it stands on the floor.
Pose upright(const Pose& world_from_plane) {
  const Vec3 inwards = world_from_plane.rotate(Vec3::UnitZ()),
             down = -(Vec3::UnitZ() - inwards * inwards.z()).normalized();
  Mat3 axes;
  axes << down.cross(-inwards), down, -inwards;
  Vec3 at = world_from_plane.translation;
  at.z() = 0;
  return {Eigen::Quaterniond(axes), at};
}

}  // namespace

Room drive_room(const MarkerSightings& seen, std::uint64_t seed) {
  require(seen.planes.size() > 1, "drive_room: these sightings are of no floor and walls");
  Draw draw(seed, 11);
  Room room;
  const auto add = [&](const std::string& name, const Vec2& low, const Vec2& high, const Pose& pose) {
    room.bodies.push_back({name, Rectangle{low, high}, pose, draw.uniform(0.4, 0.8)});
  };
  Vec3 middle = Vec3::Zero();
  for (std::size_t wall = 1; wall < seen.planes.size(); ++wall)
    middle += seen.planes[wall].translation / double(seen.planes.size() - 1);
  middle.z() = 0;
  const Vec2 corner = Vec2::Constant(kLong / 2);
  add("floor", -corner, corner, seen.planes.front() * Pose(Pose().rotation, middle));
  add("ceiling", -corner, corner, Pose(Pose().rotation, middle + Vec3(0, 0, kHigh)));
  for (std::size_t wall = 1; wall < seen.planes.size(); ++wall) {
    const Pose stands = upright(seen.planes[wall]);
    const std::string name = "wall " + std::to_string(wall);
    add(name, Vec2(-kLong / 2, -kHigh), Vec2(kLong / 2, 0), stands);
    // A cupboard and a low chest before it. The drive stays 1.5 m away.
    const Vec3 sizes[] = {{draw.uniform(0.8, 1.4), draw.uniform(1.6, 2), draw.uniform(0.35, 0.6)},
                          {draw.uniform(0.9, 1.6), draw.uniform(0.4, 0.9), draw.uniform(0.4, 0.7)}};
    double along = -draw.uniform(0.2, 1.6);
    for (const Vec3& size : sizes) {
      const Pose at = stands * Pose(Pose().rotation, Vec3(along, -size.y(), -size.z()));
      for (Body& face : box(name + (size.y() > 1 ? " cupboard" : " chest"), at, size, draw.uniform(0.3, 0.7)))
        room.bodies.push_back(std::move(face));
      along += size.x() + draw.uniform(0.3, 0.9);
    }
  }
  return room;
}

}  // namespace procam::simulate
