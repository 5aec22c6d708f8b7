#pragma once
/// Pixel -> direction of its ray, over a rectangle of pixels, to kLensTolerancePx.
///
/// The inverse of a lens model takes an iteration a pixel. Its values at nine pixels carry a biquadratic
/// through them, which is compared with the lens model forwards (a direct formula) where such polynomials err
/// most; a rectangle that fails is quartered.
#include <optional>
#include <vector>

#include "patch.hpp"
#include "procam/core/projector.hpp"
#include "procam/render/cpu.hpp"

namespace procam::render {

/// A part of a tile with the directions of its pixels' rays.
struct LensPiece {
  PixelRect rect;
  Patch direction_from_pixel;
};

/// The pieces that make up the rectangle, less the pixels that no ray leaves (outside the lens model).
std::vector<LensPiece> lens_pieces(const Projector& projector, const PixelRect& rect);

}  // namespace procam::render
