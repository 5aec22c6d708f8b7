#pragma once
/// Pixel -> direction of its ray, over a rectangle of pixels, to kLensTolerancePx (render/cpu.hpp).
///
/// The inverse of a lens model takes an iteration a pixel. Its values at nine pixels carry a biquadratic
/// through them, which is compared with the lens model forwards (a direct formula) where such polynomials err
/// most; a rectangle that fails is quartered.
#include <algorithm>
#include <vector>

#include "kernels.hpp"
#include "patch.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/lens/projector.hpp"
#include "workers.hpp"

namespace procam::render {

/// A part of a tile with the directions of its pixels' rays.
struct LensPiece {
  PixelRect rect;
  Patch direction_from_pixel;
};

/// The frame in tiles of kTileWidth x kTileHeight pixels.
struct TileGrid {
  ImageSize frame;

  int across() const { return (frame.width + kTileWidth - 1) / kTileWidth; }
  int down() const { return (frame.height + kTileHeight - 1) / kTileHeight; }
  PixelRect tile(int x, int y) const {
    return {x * kTileWidth, y * kTileHeight, std::min((x + 1) * kTileWidth, frame.width),
            std::min((y + 1) * kTileHeight, frame.height)};
  }
};

/// The pieces of every tile of a projector's frame, kept as long as the projector does not change.
class PROCAM_EXPORT LensMap {
 public:
  /// Returns whether anything changed.
  bool update(const Projector& projector, Workers& workers);

  TileGrid grid() const { return {projector_.size()}; }
  /// The pieces that make up the tile, less the pixels that no ray leaves (outside the lens model).
  const std::vector<LensPiece>& pieces(int x, int y) const {
    return pieces_[std::size_t(y * grid().across() + x)];
  }

 private:
  Projector projector_;
  std::vector<std::vector<LensPiece>> pieces_;
};

}  // namespace procam::render
