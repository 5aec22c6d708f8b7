#pragma once
/// Words over a frame, for the person in front of the projector.
#include <string>
#include <vector>

#include "procam/core/image.hpp"

namespace procam::live {

/// Lines of text in a dark box in the middle, as large as fits into half of the frame. 3 channels.
void draw_words(ImageView<std::uint8_t> frame, const std::vector<std::string>& lines);

}  // namespace procam::live
