#pragma once
/// A planar or pixel surface in the frame: its warp map, kept while the surface stays where it is, and its
/// drawing.
#include <array>
#include <type_traits>
#include <vector>

#include "footprint.hpp"
#include "lens_map.hpp"
#include "procam/core/base/export.hpp"
#include "texture.hpp"

namespace procam::render {

/// A tile of the frame while it is drawn.
template <typename Pixel>
struct Tile {
  PixelRect rect;
  int x = 0, y = 0;  ///< in the grid of tiles
  alignas(32) std::array<Pixel, kTileWidth * kTileHeight * 4> pixels;

  Pixel* row(int down) { return pixels.data() + std::ptrdiff_t(down) * kTileWidth * 4; }
};

/// Points [begin, begin + count).
struct PointRun {
  const Points& points;
  int begin, count;
};

/// A sample for each point of the run, of pixels (light) or values.
template <typename Pixel>
inline void sample(const Kernels& kernels, const TexelsView<Pixel>& level, const FilterGrid& taps,
                   const PointRun& run, Pixel* to) {
  if constexpr (std::is_same_v<Pixel, Light>)
    kernels.sample_light(level, taps, run.points, run.begin, run.count, to);
  else
    kernels.sample_values(level, run.points, run.begin, run.count, to);
}

template <typename Pixel>
inline void over(const Kernels& kernels, const Pixel* drawn, int count, Pixel* there) {
  if constexpr (std::is_same_v<Pixel, Light>)
    kernels.light_over(drawn, count, there);
  else
    kernels.values_over(drawn, count, there);
}

inline void give_alpha(const Kernels& kernels, const Value* mask, int count, Value* drawn) {
  kernels.values_alpha(mask, count, drawn);
}
inline void give_alpha(const Kernels& kernels, const Light* mask, int count, Light* drawn) {
  kernels.light_alpha(mask, count, drawn);
}

/// Where a surface is, as far as its pixels depend on it.
struct PlaneView {
  Mat3 content_from_direction;  ///< q = M d; zero where nothing can be drawn (edge-on)
  bool through_lens;            ///< d are rays (planes) or pixel positions (pixel surfaces)
  ImageSize content;
  ImageSize mask = {};  ///< 0 x 0: none

  bool operator==(const PlaneView& other) const {
    return content_from_direction == other.content_from_direction && through_lens == other.through_lens &&
           content == other.content && mask == other.mask;
  }
};

class PROCAM_EXPORT PlaneLayer {
 public:
  /// The map for this view, unless it is the one kept and the lens map is `same_lens`. `area`: samples over
  /// whole pixels, else one a pixel. Returns whether a map was made.
  bool update(const PlaneView& view, const LensMap& lens, bool same_lens, bool area, Workers& workers);

  /// The levels of the content's pyramid that are looked at.
  int levels() const { return levels_of_taps(&MapTile::taps); }
  int mask_levels() const { return levels_of_taps(&MapTile::mask_taps); }

  bool touches(int tile_x, int tile_y) const { return map_tile(tile_x, tile_y) != nullptr; }

  /// Is there a pixel of the tile that one of the two fills and the other touches?
  bool overlaps(const PlaneLayer& other, int tile_x, int tile_y) const;

  /// Does the content hide all that lies under it on this tile, if it is opaque?
  bool covers(int tile_x, int tile_y) const {
    const MapTile* tile = map_tile(tile_x, tile_y);
    return tile && tile->whole;
  }

  /// `mask` (of PlaneView::mask's size; nullptr: none) gives its alpha to the content.
  template <typename Texture>
  void draw(const Texture& texture, const Texture* mask, const Kernels& kernels,
            Tile<typename Texture::Pixel>& tile) const;

  static constexpr int kStrip = 8;  ///< rows of pixels that share their samples' grid
  /// Of the strips of a tile that it touches.
  const std::array<FilterGrid, kTileHeight / kStrip>& taps(int tile_x, int tile_y) const {
    return map_tile(tile_x, tile_y)->taps;
  }
  const std::array<FilterGrid, kTileHeight / kStrip>& mask_taps(int tile_x, int tile_y) const {
    return map_tile(tile_x, tile_y)->mask_taps;
  }
  const PlaneView& view() const { return view_; }

 private:
  /// Content coordinates over a part of the tile: q[j][3 i + k] t^j s^i, as in Patch, s = s0 + x ds and
  /// t = t0 + y dt.
  struct Piece {
    PixelRect rect;  ///< in the tile
    float s0, ds, t0, dt;
    alignas(16) float q[3][12] = {};
    RowMap row(int y, const float (&scale)[12], bool slopes) const;
  };
  /// Pixels that the content touches, and those of them that it fills.
  struct Span {
    std::uint16_t begin = 0, end = 0, full_begin = 0, full_end = 0;
    std::uint32_t first_border = 0;  ///< the shares of the others, from left to right
  };
  struct MapTile {
    bool drawn = false, whole = false;
    float u_down = 0, v_down = 0;  ///< change of (u, v), fractions of the content, by one pixel downwards
    std::uint32_t first_piece = 0, pieces = 0;
    std::array<FilterGrid, kTileHeight / kStrip> taps, mask_taps;
    std::array<Span, kTileHeight> spans;
  };
  struct DrawnPiece {
    Patch q;
    PixelRect rect;  ///< in the tile
    bool filled;
  };
  struct Band {
    std::vector<DrawnPiece> drawn;  ///< of the tile that is being made
    int first = 0;                  ///< the tile of tiles[0]
    std::vector<MapTile> tiles;
    std::vector<Piece> pieces;
    std::vector<Light> border;  ///< share of the pixel that is covered, of kFull
  };

  const MapTile* map_tile(int x, int y) const {
    const Band& band = bands_[std::size_t(y)];
    if (x < band.first || x >= band.first + int(band.tiles.size())) return nullptr;
    const MapTile& tile = band.tiles[std::size_t(x - band.first)];
    return tile.drawn ? &tile : nullptr;
  }
  int levels_of_taps(std::array<FilterGrid, kTileHeight / kStrip> MapTile::*taps) const;
  /// Where a row's pixels look.
  template <typename Pixel>
  using RowMemory = std::conditional_t<std::is_same_v<Pixel, Light>, Points, RowCells>;
  /// Row `y` of a tile in its band.
  struct TileRow {
    const MapTile& map;
    const Band& band;
    int y;
  };
  /// Writes the samples of a row's pixels that the content touches. `memory`: it may be used.
  template <typename Pixel>
  void sample_row(const TileRow& tile_row, const TexelsView<Pixel>& level, const FilterGrid& taps,
                  const Kernels& kernels, RowMemory<Pixel>& memory, Pixel* to) const;
  void make_band(int y, const LensMap& lens, bool area);
  MapTile make_tile(const PixelRect& rect, const LensPiece* pieces, std::size_t count, bool area, Band& band);
  /// Part of the content in a part of the tile, unless all is outside; true: the content fills that part.
  bool add_piece(const LensPiece& of_lens, const PixelRect& tile, Band& band) const;
  static Footprint drawn_at(const std::vector<DrawnPiece>& drawn, int x, int y);
  /// Of a tile that the content does not fill.
  static void find_spans(const PixelRect& rect, MapTile& tile, Band& band);
  /// The samples' grid of each strip, by the sizes of some pixels in the content.
  static void choose_strips(const MapTile& tile, const std::vector<DrawnPiece>& drawn, int height,
                            ImageSize content, std::array<FilterGrid, kTileHeight / kStrip>& taps);

  PlaneView view_{};
  std::vector<Band> bands_;
};

}  // namespace procam::render
