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
#include "procam/core/surface.hpp"

namespace procam::render {

/// Unit borders, so that floats do: an edge's place to 1e-7. nearness . d = 1 / distance in lengths of d.
struct Facet : Cone {
  Mat3 content_from_direction;  ///< q
};

/// f . d
inline float along(const float (&f)[3], const Vec3& d) {
  return f[0] * float(d.x()) + f[1] * float(d.y()) + f[2] * float(d.z());
}

inline bool meets(const Facet& facet, const Vec3& d) {
  for (const auto& border : facet.borders)
    if (!(along(border, d) >= 0)) return false;
  return along(facet.nearness, d) > 0;
}

/// Pixels [x0, x1) x [y0, y1) that a facet may touch, or whose neighbours it may; and its place in the list.
struct FacetBox {
  int x0, y0, x1, y1, facet;
};

class RoomLayer {
 public:
  RoomLayer(const PlacedPlane& placed, const TileGrid& grid);
  RoomLayer(const PlacedMesh& placed, const Projector& projector, const TileGrid& grid, Workers& workers);

  bool is_plane() const { return is_plane_; }
  const TileGrid& grid() const { return grid_; }
  const std::vector<Facet>& facets() const { return facets_; }
  /// As the kernels want them; of a mesh or a plane that is seen not from its edge.
  const std::vector<FacetView>& views() const { return views_; }
  /// Where each may be.
  const std::vector<FacetBox>& boxes() const { return boxes_; }
  /// Those that may touch a tile.
  const std::vector<FacetBox>& boxes(int tile_x, int tile_y) const {
    return is_plane_ ? boxes_ : tiles_[std::size_t(tile_y * grid_.across() + tile_x)];
  }
  /// The nearest facet that the ray d of a pixel meets; nullptr: none.
  const Facet* nearest(int x, int y, const Vec3& d) const {
    const Facet* found = nullptr;
    for (const FacetBox& box : boxes(x / kTileWidth, y / kTileHeight)) {
      const Facet& facet = facets_[std::size_t(box.facet)];
      if (x >= box.x0 && x < box.x1 && y >= box.y0 && y < box.y1 && meets(facet, d) &&
          (!found || along(facet.nearness, d) > along(found->nearness, d)))
        found = &facet;
    }
    return found;
  }

 private:
  void make_views();
  void sort_into_tiles();

  bool is_plane_;
  TileGrid grid_;
  std::vector<Facet> facets_;
  std::vector<FacetView> views_;
  std::vector<FacetBox> boxes_;
  std::vector<std::vector<FacetBox>> tiles_;  ///< of a mesh
};

}  // namespace procam::render
