#pragma once
/// The picture of a projection's plan.
#include <string>

#include "procam/analyze/planner.hpp"

namespace procam::report {

/// The plan as one SVG file, complete in itself: the wall seen straight on, with the lit area, its pixels'
/// size as colours, the target and the largest undistorted rectangle; the projector and its light from above
/// and from the side; the figures. The same plan gives the same text, byte by byte, in every locale.
std::string plan_picture(const analyze::ProjectionPlan& plan);

}  // namespace procam::report
