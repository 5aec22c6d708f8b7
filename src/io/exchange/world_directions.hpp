#pragma once
/// Directions in the world.
#include "procam/io/exchange/world_axes.hpp"

namespace procam::io {

Directions directions_in_world(WorldUp up);

}  // namespace procam::io
