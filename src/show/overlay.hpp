#pragma once
/// Words and marks over a frame, for the person in front of the projector.
#include <string>
#include <vector>

#include "procam/core/base/image.hpp"
#include "procam/core/base/types.hpp"

namespace procam::show {

/// Lines of text in a dark box in the middle, as large as fits into half of the frame. 3 channels.
void draw_words(ImageView<std::uint8_t> frame, const std::vector<std::string>& lines);

/// A white cross with a dark border round a pixel, open in the middle, so that what is under it can be seen. 3 channels.
void draw_cross(ImageView<std::uint8_t> frame, const Vec2& pixel);

/// A white line with a dark border through the pixels, closed. 3 channels.
void draw_ring(ImageView<std::uint8_t> frame, const Points2& pixels);

}  // namespace procam::show
