#pragma once
/// A scene's surfaces in a projector's frame, and the order in which they are drawn: what every renderer
/// shares.
#include <optional>
#include <vector>

#include "mesh_layer.hpp"
#include "plane_layer.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/surface/scene.hpp"

namespace procam::render {

/// Throws std::invalid_argument for content that is empty or has 2 or more than 4 channels, and for a mask
/// with more than one; Error(kInput) for sizes that are not drawn (render/cpu.hpp).
PROCAM_EXPORT void require_drawable(const Scene& scene, ImageSize frame);

PROCAM_EXPORT bool same_view(ViewU8 a, ViewU8 b);

/// A mask as the alpha of black, in `memory`.
PROCAM_EXPORT ViewU8 as_alpha(ViewU8 mask, std::vector<std::uint8_t>& memory);

/// Where one item of the scene is; kept while it stays there.
struct PROCAM_EXPORT Layer {
  PlaneLayer plane;               ///< of a plane or a pixel surface
  std::optional<MeshLayer> room;  ///< of a plane, a mesh or a curved pixel surface
  std::uint64_t made = 0;         ///< how many times anything was

  /// Returns whether anything had to be made.
  bool place(const SceneItem& shown, const Projector& projector, const LensMap& lens, bool same_lens,
             bool area, Workers& workers);

  bool is_mesh() const { return room && !room->is_plane(); }
  /// Of triangles: those of a curved pixel surface, which has no place in the room?
  bool is_in_pixels() const { return in_pixels_ != nullptr; }
  bool touches(int tile_x, int tile_y) const {
    return is_mesh() ? room->boxes(tile_x, tile_y).count > 0 : plane.touches(tile_x, tile_y);
  }
  /// The levels of its content's pyramid that are looked at.
  int levels(ImageSize content) const { return is_mesh() ? levels_of(content) : plane.levels(); }
  int mask_levels(ImageSize mask) const { return is_mesh() ? levels_of(mask) : plane.mask_levels(); }

 private:
  bool place_in_pixels(const PlacedPixels& placed, const Projector& projector, const LensMap& lens,
                       bool same_lens, Workers& workers);

  PlacedMesh mesh_;                        ///< as it was
  std::shared_ptr<const Mesh> in_pixels_;  ///< of a curved pixel surface, as it was
};

/// What is drawn on a tile, back to front. Planes in the room are put in the order of their depth; where that
/// changes within the tile, and where there are meshes, all are cast at (mesh_tile.hpp). Pixel surfaces lie
/// where the scene has them, and part what is in the room before them from what comes after.
///
/// Its memory is kept from tile to tile.
class PROCAM_EXPORT TileSteps {
 public:
  static constexpr int kCast = -1;

  /// Items, by their places in the scene; cast at is what lies between two kCast.
  const std::vector<int>& find(const std::vector<Layer>& layers, const LensMap& lens, int tile_x, int tile_y);

 private:
  void add_group(const std::vector<Layer>& layers, const LensMap& lens, int x, int y);
  bool find_order(const std::vector<Layer>& layers, const LensMap& lens, int x, int y);

  std::vector<int> steps_;
  std::vector<int> group_;          ///< in the room, between two pixel surfaces
  std::vector<std::int8_t> order_;  ///< [later, earlier]: the later one is drawn first
};

}  // namespace procam::render
