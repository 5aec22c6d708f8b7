#pragma once
/// Measured points of surfaces, in no order.
#include <vector>

#include "procam/core/base/types.hpp"

namespace procam {

struct PointCloud {
  Points3 points;   ///< metres
  Points3 normals;  ///< unit, towards the device that measured them; one a point, or none at all
  std::vector<double>
      sigma;  ///< standard deviation along the device's ray, metres; one a point, or none at all
};

}  // namespace procam
