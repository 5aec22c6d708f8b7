#pragma once
/// Lines and numbers on a picture, for people to see what a tool saw.
#include <array>
#include <cstdint>

#include "procam/core/base/image.hpp"

namespace procam::tools {

using Colour = std::array<std::uint8_t, 3>;

/// R G B from grey.
ImageU8 to_colour(const ImageU8& grey);

/// One pixel wide; parts outside the image are clipped.
void draw_line(ImageU8& picture, const Vec2& from, const Vec2& to, const Colour& colour);

/// A whole number, digits of 6x10 pixels, the first one's top left at `at`.
void draw_number(ImageU8& picture, const Vec2& at, int number, const Colour& colour);

}  // namespace procam::tools
