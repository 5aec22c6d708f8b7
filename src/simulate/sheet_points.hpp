#pragma once
/// Points on the sheet.
#include "procam/core/board/board_artwork.hpp"
#include "procam/simulate/world.hpp"

namespace procam::simulate {

/// In the board's frame, metres.
inline Vec3 middle_of_print(const Board& layout) {
  const ArtworkRectangle print = print_of(layout);
  return (Vec3() << 0.5 * (print.low + print.high), 0).finished();
}

/// Where the light of a projector pixel falls on the sheet, in the board's frame, metres; nullopt where it
/// misses the sheet.
std::optional<Vec2> light_on_sheet(const World& world, const Vec2& projector_pixel);

}  // namespace procam::simulate
