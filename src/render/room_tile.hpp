#pragma once
/// A tile on which surfaces of the room may hide each other: cast at, pixel by pixel.
///
/// Pixels that see the same surfaces as their neighbours, in the same order, are drawn in rows like those of
/// a plane. The others, where something ends or cuts through something, are cast at 16 times.
#include <cstdint>

#include "footprint.hpp"
#include "plane_layer.hpp"
#include "room_layer.hpp"

namespace procam::render {

/// Share of the distance within which two surfaces lie together, and the later one shows.
inline constexpr float kTogether = 1e-3f;

/// A layer with what is shown on it.
template <typename Texture>
struct RoomItem {
  const RoomLayer* layer;
  const Texture* texture;
  const Texture* mask = nullptr;  ///< gives its alpha to the content

  bool opaque() const { return texture->opaque() && !mask; }
};

/// Its memory is kept from tile to tile.
class RoomTile {
 public:
  /// Draws the items (in the scene's order) over what is on the tile. `area`: the mean over pixels, else one
  /// sample each.
  template <typename Texture>
  void draw(const std::vector<RoomItem<Texture>>& items, const std::vector<LensPiece>& pieces, bool area,
            const Kernels& kernels, Tile<typename Texture::Pixel>& tile);

 private:
  static constexpr int kAcross = kTileWidth + 2, kDown = kTileHeight + 2;  ///< a pixel more on each side
  static constexpr int kPixels = kAcross * kDown;
  static constexpr int kBlock = 16, kStrip = 8;  ///< pixels, across and down, that share their samples
  static constexpr int kBlocks = kTileWidth / kBlock;

  /// What one item shows, everywhere on the tile; facet -1: nothing.
  struct Hits {
    float nearness[kPixels];
    std::int32_t facet[kPixels];
  };
  struct Fragment {
    int item, facet;
    float nearness;
  };

  static int place(int x, int y) { return (y + 1) * kAcross + x + 1; }  ///< of a pixel, in the tile
  Vec3 ray(int at) const { return {double(x_[at]), double(y_[at]), double(z_[at])}; }
  bool known(int at) const { return x_[at] == x_[at]; }
  Vec3 slope(int at, int step) const;
  Footprint footprint(const Facet& facet, int at) const;
  void follow(const LensPiece& piece, const PixelRect& rect);
  void cast(const RoomLayer& layer, int tile_x, int tile_y, const PixelRect& rect, Hits& hits);
  template <typename Texture>
  bool is_even(const std::vector<RoomItem<Texture>>& items, int at) const;
  template <typename Texture>
  Taps taps_of(const RoomLayer& layer, const Texture& texture, const Hits& hits,
               const PixelRect& block) const;
  template <typename Texture>
  void draw_row(const std::vector<RoomItem<Texture>>& items, int y, const bool (&edge)[kTileWidth],
                const Kernels& kernels, Tile<typename Texture::Pixel>& tile);
  template <typename Texture>
  void draw_edge(const std::vector<RoomItem<Texture>>& items, int x, int y, bool area, const Kernels& kernels,
                 Tile<typename Texture::Pixel>& tile);
  static void nearest_first(std::vector<Fragment>& fragments);

  float x_[kPixels], y_[kPixels], z_[kPixels];  ///< the rays' directions; NaN: none
  std::vector<Hits> hits_;

  template <typename Pixel>
  std::vector<Pixel>& drawn_pixels() {
    if constexpr (std::is_same_v<Pixel, Light>)
      return drawn_light_;
    else
      return drawn_values_;
  }

  std::vector<Fragment> fragments_, candidates_;
  std::vector<Taps> taps_, mask_taps_;  ///< [item, block]
  std::vector<Light> drawn_light_;      ///< a row of every item
  std::vector<Value> drawn_values_;
};

}  // namespace procam::render
