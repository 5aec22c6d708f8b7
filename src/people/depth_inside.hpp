#pragma once
/// Distance to the border of a polygon.
#include "procam/people/interaction.hpp"

namespace procam::people {

/// Metres from the polygon's edge, positive inside (even-odd); at least 3 corners (std::invalid_argument).
double depth_inside(const Points2& polygon, const Vec2& point);

}  // namespace procam::people
