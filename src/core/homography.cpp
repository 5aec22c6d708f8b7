#include "procam/core/geometry/detail/homography_body.hpp"
#include "procam/core/geometry/detail/homography_fit_body.hpp"
#include "procam/core/geometry/detail/homography_robust_body.hpp"
