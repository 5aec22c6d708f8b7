#pragma once
/// A surface in the room as plane facets that rays meet: what is cast at where surfaces may hide each other.
///
/// A direction d meets a triangle with corners P_i where its homogeneous barycentric coordinates
///
///   b = [P_1 P_2 P_3]^-1 d
///
/// are all >= 0 (Olano and Greer, Triangle scan conversion using 2D homogeneous coordinates, 1997); 1 / sum b
/// is then how many lengths of d away, and sum b_i (u_i, v_i, 1) the homogeneous content coordinates. Corners
/// behind the projector need no clipping, and the lens is exact since d is. A planar surface is one facet
/// with the four borders of its content.
#include "lens_map.hpp"
#include "procam/core/surface/surface.hpp"

namespace procam::render {

/// f . d
inline float along(const float (&f)[3], const Vec3& d) {
  return f[0] * float(d.x()) + f[1] * float(d.y()) + f[2] * float(d.z());
}

/// Boxes in the order of their facets.
struct FacetBoxes {
  const FacetBox* data = nullptr;
  std::size_t count = 0;

  const FacetBox* begin() const { return data; }
  const FacetBox* end() const { return data + count; }
};

class MeshLayer {
 public:
  MeshLayer(const PlacedPlane& placed, const TileGrid& grid);
  MeshLayer(const PlacedMesh& placed, const Projector& projector, const TileGrid& grid, Workers& workers)
      : is_plane_(false) {
    move(placed, projector, grid, workers);
  }

  /// Of a mesh: as if made anew, in the memory that it has.
  void move(const PlacedMesh& placed, const Projector& projector, const TileGrid& grid, Workers& workers);

  bool is_plane() const { return is_plane_; }
  const TileGrid& grid() const { return grid_; }
  /// Of a mesh's triangles, in their order. Those that no ray meets are in no box, and hold nothing. Of a
  /// plane that is seen from its edge, none.
  const std::vector<Facet>& facets() const { return facets_; }
  /// The borders that count.
  int borders() const { return is_plane_ ? 4 : 3; }
  /// Where each may be.
  FacetBoxes boxes() const { return {boxes_.data(), boxes_.size()}; }
  /// Those that may touch a tile, or pixels next to it.
  FacetBoxes boxes(int tile_x, int tile_y) const {
    if (is_plane_) return boxes();
    const std::size_t tile = std::size_t(tile_y * grid_.across() + tile_x);
    return {tile_boxes_.data() + tile_ends_[tile], tile_ends_[tile + 1] - tile_ends_[tile]};
  }
  bool meets(const Facet& facet, const Vec3& d) const {
    for (int i = 0; i < borders(); ++i)
      if (!(along(facet.borders[i], d) >= 0)) return false;
    return along(facet.nearness, d) > 0;
  }
  /// May the facet touch the pixel's area?
  static bool touches(const FacetBox& box, int x, int y) {
    return x >= box.x0 - 1 && x <= box.x1 && y >= box.y0 - 1 && y <= box.y1;
  }
  /// The nearest facet that a ray d of a pixel meets; nullptr: none.
  const Facet* nearest(int x, int y, const Vec3& d) const {
    const Facet* found = nullptr;
    for (const FacetBox& box : boxes(x / kTileWidth, y / kTileHeight)) {
      if (!touches(box, x, y)) continue;
      const Facet& facet = facets_[std::size_t(box.facet)];
      if (meets(facet, d) && (!found || along(facet.nearness, d) > along(found->nearness, d))) found = &facet;
    }
    return found;
  }

 private:
  /// A corner where light goes: its pixel and, for the larger ends of boxes, the negative of it. NaN:
  /// nowhere.
  struct CornerPixel {
    float x, y, minus_x, minus_y;
  };
  /// Triangles that one thread works on: [first, last). Their boxes lie from `first` on at first.
  struct Part {
    std::size_t first = 0, last = 0, boxes = 0;
    std::vector<std::uint32_t> in_tile;  ///< how many boxes; then, where the part's next goes
  };
  struct ViewCone;

  void place_corners(const PlacedMesh& placed, const Projector& projector, Workers& workers);
  void set_up(const PlacedMesh& placed, const Projector& projector, const ViewCone& cone, Part& part);
  FacetBox box_of(const Projector& projector, const ViewCone& cone, const std::array<int, 3>& triangle) const;
  /// Calls visit(tile) for those that the box, or the pixels round it, touch.
  template <typename Visit>
  void for_tiles(const FacetBox& box, const Visit& visit) const;
  void sort_into_tiles(Workers& workers);

  bool is_plane_;
  TileGrid grid_;
  std::vector<Facet> facets_;
  std::vector<FacetBox> boxes_;
  // Of a mesh:
  std::vector<Vec3> corners_;  ///< in the projector's frame
  std::vector<CornerPixel> pixels_;
  std::vector<Part> parts_;
  std::vector<FacetBox> tile_boxes_;    ///< tile after tile
  std::vector<std::size_t> tile_ends_;  ///< and where each tile's begin; at the end, where the last ends
};

}  // namespace procam::render
