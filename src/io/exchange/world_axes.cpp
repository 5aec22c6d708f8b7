#include "procam/io/exchange/world_axes.hpp"

#include "exchange/world_directions.hpp"
#include "procam/core/base/error.hpp"

namespace procam::io {

WorldUp parse_world_up(const std::string& text) {
  if (text == "z") return WorldUp::kZ;
  if (text == "y") return WorldUp::kY;
  if (text == "-y") return WorldUp::kMinusY;
  throw Error(ErrorKind::kInput, "'" + text + "'", "it is no upward axis", "give z, y or -y");
}

Directions directions_in_world(WorldUp up) {
  switch (up) {
    case WorldUp::kZ:
      return {-Vec3::UnitY(), Vec3::UnitZ(), Vec3::UnitX()};
    case WorldUp::kY:
      return {Vec3::UnitX(), Vec3::UnitY(), -Vec3::UnitZ()};
    case WorldUp::kMinusY:
      break;
  }
  return {Vec3::UnitX(), -Vec3::UnitY(), Vec3::UnitZ()};
}

Mat3 program_from_world(const Directions& in_program, WorldUp up) {
  const Directions in_world = directions_in_world(up);
  Mat3 program_from_directions, world_from_directions;
  program_from_directions << in_program.right, in_program.up, in_program.forward;
  world_from_directions << in_world.right, in_world.up, in_world.forward;
  return program_from_directions * world_from_directions.transpose();
}

}  // namespace procam::io
