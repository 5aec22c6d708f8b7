#pragma once
/// By how much the edges of a board's markers are displaced towards their dark side.
///
/// Blur leaves a straight edge where its grey level is half way between dark and light, in linear light. A
/// tone curve (gamma) moves that level towards the dark side, and ink or light spreads: all edges of all
/// markers move alike, so that markers become smaller or larger, each about its own middle. With M the map
/// of the whole board, corner c of a marker that is printed or shown at b appears at
///   M(b - (s_x g_x(b), s_y g_y(b))),   s = (+-1, +-1) outwards,
///   g_k(b) = g_k0 + g_k1 x + g_k2 y    (x, y over the board, -1 .. 1)
/// A smooth M cannot take up signs that alternate from corner to corner, so M and g are fitted together.
#include <vector>

#include "markers.hpp"
#include "procam/core/base/image.hpp"

namespace procam::detect {

/// A corner of a marker, and where it was found.
struct FoundCorner {
  Vec2 in_board;  ///< as printed or shown
  Vec2 outwards;  ///< (+-1, +-1)
  Vec2 pixel;
  Mat2 covariance;
};

/// Moves every pixel by the displacement, back to the corner, and adds the displacement's uncertainty to the
/// covariance: that of the fit, and the markers' own variance about it. `corners` has four of each marker in
/// a row. Fewer than three markers determine too little: their corners stay as they are.
void remove_edge_shift(std::vector<FoundCorner>& corners, ImageSize size);

}  // namespace procam::detect
