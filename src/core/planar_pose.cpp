#include "procam/core/geometry/detail/planar_pose_body.hpp"
