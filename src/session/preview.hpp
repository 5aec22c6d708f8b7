#pragma once
/// Small images of a session's views.
#include <string>
#include <vector>

#include "procam/core/rig/view_image.hpp"

namespace procam::session {

/// The brightest of a view's frames, at most 480 pixels wide and high: the mean of scale x scale pixels of the green channel.
/// Throws std::invalid_argument without frames.
ViewImage preview(const std::string& view, const std::string& camera, const std::vector<ViewU8>& frames);

}  // namespace procam::session
