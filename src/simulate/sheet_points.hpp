#pragma once
/// Points of light on the sheet.
#include "procam/simulate/world.hpp"

namespace procam::simulate {

/// Where the light of a projector pixel falls on the sheet, in the board's frame, metres; nullopt where it
/// misses the sheet.
std::optional<Vec2> light_on_sheet(const World& world, const Vec2& projector_pixel);

}  // namespace procam::simulate
