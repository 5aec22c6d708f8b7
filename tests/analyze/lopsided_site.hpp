#pragma once
/// A projector at an angle to a wall, for the planner and its picture.
#include "procam/analyze/planner.hpp"

namespace procam::test {

inline analyze::DataSheet lopsided_sheet() {
  analyze::DataSheet sheet;
  sheet.resolution = {1280, 801};
  sheet.throw_ratio = 0.83;
  sheet.lens_shift = Vec2(-0.07, 0.46);
  sheet.lumens = 2900;
  sheet.f_number = 1.9;
  sheet.focal_length = 0.0137;
  return sheet;
}

inline analyze::Site lopsided_site() {
  analyze::Site site;
  site.projector_from_wall = analyze::pose_before_wall(1.63, 21 * kDegree, -9 * kDegree, 4 * kDegree);
  return site;
}

}  // namespace procam::test
