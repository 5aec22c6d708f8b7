#pragma once
/// A projection's plan for people: as JSON, as lines, as a picture.
#include <string>
#include <vector>

#include "procam/analyze/planner.hpp"
#include "procam/core/base/export.hpp"

namespace procam::report {

/// The plan's fields as JSON text; metres unless a name ends otherwise.
PROCAM_EXPORT std::string to_json(const analyze::ProjectionPlan& plan);

/// The figures as lines of a console.
PROCAM_EXPORT std::vector<std::string> lines(const analyze::ProjectionPlan& plan);

/// The plan as one SVG file, complete in itself: the wall seen straight on, with the lit area, its pixels'
/// size as colours, the target and the largest undistorted rectangle; the projector and its light from above
/// and from the side; the figures. The same plan gives the same text, byte by byte, in every locale.
PROCAM_EXPORT std::string plan_picture(const analyze::ProjectionPlan& plan);

}  // namespace procam::report
