#pragma once
/// A tile on which surfaces of the room may hide each other: cast at, pixel by pixel.
///
/// Pixels that see the same surfaces as their neighbours, in the same order, are drawn in rows like those of
/// a plane. The others, where something ends or cuts through something, are cast at 16 times.
#include <cstdint>

#include "footprint.hpp"
#include "mesh_layer.hpp"
#include "plane_layer.hpp"

namespace procam::render {

/// Share of the distance within which two surfaces lie together, and the later one shows.
inline constexpr float kCoplanarTolerance = 1e-3f;

/// A surface as far as it matters where its pixels lie and look.
struct CastItem {
  const MeshLayer* layer = nullptr;
  std::uint64_t made = 0;  ///< another number when the layer was made anew
  ImageSize content;
  int levels = 1;  ///< of its pyramid
  ImageSize mask;  ///< 0 x 0: none
  int mask_levels = 1;
  bool opaque = true;  ///< the content is, and has no mask

  bool operator==(const CastItem& other) const {
    return layer == other.layer && made == other.made && content == other.content && levels == other.levels &&
           mask == other.mask && mask_levels == other.mask_levels && opaque == other.opaque;
  }
};

/// What a surface shows.
template <typename Texture>
struct ItemTextures {
  const Texture* content = nullptr;
  const Texture* mask = nullptr;  ///< gives its alpha to the content; nullptr: none

  bool opaque() const { return content->opaque() && !mask; }
};

/// Memory to draw with, kept from tile to tile.
template <typename Pixel>
struct RoomRows {
  std::vector<Pixel> drawn;  ///< a row of every item
  Points points;
};

/// What was cast at a tile: kept as long as its surfaces stay where they are.
class MeshTile {
 public:
  bool shows(const std::vector<CastItem>& items) const { return cast_ && items == items_; }
  /// Are these the items that it was to show the last time? From now on they are.
  bool expects(const std::vector<CastItem>& items) {
    if (items == items_) return true;
    items_ = items;
    cast_ = false;
    return false;
  }

  /// Draws the items' textures over what is on the tile.
  template <typename Texture>
  void draw(const std::vector<ItemTextures<Texture>>& textures, const Kernels& kernels,
            RoomRows<typename Texture::Pixel>& rows, Tile<typename Texture::Pixel>& tile) const;

 private:
  friend class MeshCaster;
  static constexpr int kBlock = 16, kStrip = 8;  ///< pixels, across and down, that share their samples
  static constexpr int kBlocks = kTileWidth / kBlock, kStrips = kTileHeight / kStrip;
  static constexpr int kSub = 16;       ///< casts for an edge pixel
  static constexpr int kMaxParts = 24;  ///< facets in one; the rest are skipped

  /// One item in a row: pixels [begin, end) look at points_ from `first` on, all u, then all v, and so on.
  struct Row {
    std::uint8_t begin = 0, end = 0;
    std::uint32_t first = 0;
  };
  /// What an edge pixel shows of one facet; content coordinates as fractions.
  struct Part {
    int item;
    FilterGrid taps, mask_taps;
    float texcoords[6];
  };
  struct Edge {
    std::uint8_t x, y;
    std::uint32_t first_part, parts;
    std::uint32_t first_order;  ///< 16 times: how many parts, and which, farthest first
  };
  template <typename Texture>
  void draw_row(const std::vector<ItemTextures<Texture>>& textures, int y, const std::uint16_t*& run,
                const Kernels& kernels, RoomRows<typename Texture::Pixel>& rows,
                Tile<typename Texture::Pixel>& tile) const;
  template <typename Texture>
  void draw_edge(const std::vector<ItemTextures<Texture>>& textures, const Edge& edge, const Kernels& kernels,
                 RoomRows<typename Texture::Pixel>& rows, Tile<typename Texture::Pixel>& tile) const;

  std::vector<CastItem> items_;
  bool cast_ = false;                         ///< at them; else nothing below counts
  int texcoords_ = 2;                         ///< numbers a pixel: u, v, and with their slopes 6
  std::vector<Row> rows_;                     ///< [row, item]
  std::vector<float> points_;                 ///< fractions of the content
  std::vector<FilterGrid> taps_, mask_taps_;  ///< [strip, item, block]
  std::vector<std::uint16_t> runs_;  ///< a row's: how many pixels, how many items, and which, farthest first
  std::vector<Edge> edges_;          ///< row by row
  std::vector<Part> parts_;
  std::vector<std::uint8_t> orders_;
};

/// A tile of the frame: its place in the grid of tiles, and its pixels.
struct GridTile {
  int x = 0, y = 0;
  PixelRect rect;
};

/// Casts at tiles. Its memory is kept from tile to tile.
class MeshCaster {
 public:
  /// The items are in the scene's order. `area`: the mean over pixels, else one sample each.
  void cast(const std::vector<CastItem>& items, const std::vector<LensPiece>& pieces, bool area,
            const Kernels& kernels, const GridTile& tile, MeshTile& to);

 private:
  struct Fragment {
    int item, facet;
    float nearness;
  };

  Vec3 ray(int at) const { return {double(rays_.x[at]), double(rays_.y[at]), double(rays_.z[at])}; }
  bool known(int at) const { return rays_.x[at] == rays_.x[at]; }
  /// Change of the ray of a pixel by one of `step` places.
  Vec3 slope(int at, int step) const {
    const bool forward = known(at + step), backward = known(at - step);
    return (forward && backward ? 0.5 : 1.0) *
           (ray(forward ? at + step : at) - ray(backward ? at - step : at));
  }
  void follow(const LensPiece& piece, const PixelRect& rect, const Kernels& kernels);
  void find_hits(const MeshLayer& layer, const GridTile& tile, const Kernels& kernels, Hits& hits) const;
  bool is_even(const std::vector<CastItem>& items, int at) const;
  bool is_visible(const std::vector<CastItem>& items, int item, int at) const;
  FilterGrid taps_of(ImageSize content, int levels, const Hits& hits, const TexCoords* rows,
                     const PixelRect& block) const;
  void add_row(const std::vector<CastItem>& items, int y, int width, const RowBits& edges, MeshTile& to);
  void add_runs(const std::vector<CastItem>& items, int y, int width, const RowBits& edges, MeshTile& to);
  void add_edge(const Kernels& kernels, int x, int y, bool area, const GridTile& tile, MeshTile& to);
  void find_sub_hits(const MeshLayer& layer, const Kernels& kernels, int x, int y, const GridTile& tile);
  static void nearest_first(std::vector<Fragment>& fragments);

  Rays rays_, right_, down_;          ///< directions, and (area) their changes by one pixel; x NaN: none
  std::vector<Hits> hits_;            ///< [item]
  std::vector<TexCoords> texcoords_;  ///< [row of a strip, item]
  RowBits met_;                       ///< by the only item, in the row
  std::vector<Fragment> fragments_;
  // Of an edge pixel's sub-pixels; rays and hits in the first row.
  std::vector<Fragment> sub_fragments_[MeshTile::kSub];
  Rays sub_rays_;
  Hits sub_hits_;
  std::vector<FacetBox> sub_boxes_;
};

}  // namespace procam::render
