#pragma once
/// Surfaces in the room, that hide each other as the projector sees them.
///
/// Where one surface is in a tile, or planes whose order is the same all over it, the planes are drawn one
/// over the other, farthest first. Else each pixel is cast at: a direction d meets a triangle with corners
/// P_i where its homogeneous barycentric coordinates
///
///   b = [P_1 P_2 P_3]^-1 d
///
/// are all >= 0 (Olano and Greer, Triangle scan conversion using 2D homogeneous coordinates, 1997); 1 / sum b
/// is then how many lengths of d away, and sum b_i (u_i, v_i, 1) the homogeneous content coordinates. Corners
/// behind the projector need no clipping, and the lens is exact since d is. Pixels where something ends or
/// the order changes, seen from their neighbours, are cast at 16 times.
#include <cstdint>
#include <memory>

#include "lens_map.hpp"
#include "plane_layer.hpp"
#include "procam/core/scene.hpp"

namespace procam::render {

/// One plane or one triangle: half-spaces of directions, content and nearness, all linear in d.
struct Facet {
  std::array<Vec3, 4> borders;  ///< d is inside where border . d >= 0 for each of the first `border_count`
  int border_count = 0;
  Mat3 content_from_direction;  ///< q
  Vec3 nearness;                ///< nearness . d = 1 / distance in lengths of d
};

/// Pixels [x0, x1) x [y0, y1) that a facet may touch, and its place in the list.
struct FacetBox {
  int x0, y0, x1, y1, facet;
};

/// Share of the distance within which two surfaces lie together, and the later one shows.
inline constexpr double kTogether = 1e-3;

/// A surface made ready: its facets in the projector's frame, sorted into tiles.
class RoomLayer {
 public:
  RoomLayer(const PlacedPlane& placed, const TileGrid& grid);
  RoomLayer(const PlacedMesh& placed, const Projector& projector, const TileGrid& grid);

  bool is_plane() const { return is_plane_; }
  const std::vector<Facet>& facets() const { return facets_; }
  /// Those that may touch a tile.
  const std::vector<FacetBox>& boxes(int tile_x, int tile_y) const {
    return is_plane_ ? plane_box_ : tiles_[std::size_t(tile_y * grid_.across() + tile_x)];
  }

 private:
  void sort_into_tiles(const std::vector<FacetBox>& boxes);

  bool is_plane_;
  TileGrid grid_;
  std::vector<Facet> facets_;
  std::vector<FacetBox> plane_box_;           ///< of a plane: everywhere
  std::vector<std::vector<FacetBox>> tiles_;  ///< of a mesh, row by row
};

/// A layer with what is shown on it.
template <typename Texture>
struct RoomItem {
  const RoomLayer* layer;
  const Texture* texture;
};

/// Casts at every pixel of a tile and draws what is there over it. `area`: means over whole pixels.
template <typename Texture>
void draw_cast(const std::vector<RoomItem<Texture>>& items, const std::vector<LensPiece>& pieces,
               const Kernels& kernels, bool area, Tile<typename Texture::Pixel>& tile);

}  // namespace procam::render
