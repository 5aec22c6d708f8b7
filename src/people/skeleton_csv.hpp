#pragma once
/// Recorded CSV logs of skeletons.
#include "procam/people/skeleton_reader.hpp"

namespace procam::people {

/// A recorded log of one person, a header and a frame a line: `t_s`, then `<joint>_x_m, _y_m, _z_m, _ok` in
/// any order; pixels and columns of other names are passed over. Joints are called as here (left_hand) or as
/// Kinect v1 did (handLeft, shoulderCenter, hipCenter). _ok 0 is stale: absent. Throws Error(kInput) for a
/// text without such a header.
ParsedSkeletons parse_skeleton_csv(std::string_view text);

}  // namespace procam::people
