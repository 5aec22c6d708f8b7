#pragma once
/// The first surface that a ray meets.
#include "procam/simulate/room.hpp"

namespace procam::simulate {

struct RoomHit {
  int body = 0;        ///< number in the list
  double lengths = 0;  ///< of the ray's direction, from its origin
  Vec3 point_in_room = Vec3::Zero();
  Vec3 normal_in_room = Vec3::UnitZ();  ///< unit, towards the ray's origin; of a mesh, its triangle's
  Vec2 uv = Vec2::Zero();
  bool front = true;  ///< the painted side: z < 0 of planes, the outer of spheres and cylinders
};

/// The first thing on the ray's way; nullopt when there is none. Throws std::invalid_argument for a shape
/// without extent or a cutout without a mask of one channel.
std::optional<RoomHit> nearest_hit(const Room& room, const Ray& ray_in_room);

}  // namespace procam::simulate
