#pragma once
/// Words over a frame, for the person in front of the projector.
#include <string>
#include <vector>

#include "procam/core/base/image.hpp"

namespace procam::show {

/// Lines of text in a dark box in the middle, as large as fits into half of the frame. 3 channels.
void draw_words(ImageView<std::uint8_t> frame, const std::vector<std::string>& lines);

}  // namespace procam::show
