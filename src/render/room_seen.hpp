#pragma once
/// What of a room a device sees at each of its pixels: the nearest facet. For the questions of visibility
/// between a projector and an eye.
#include "mesh_layer.hpp"
#include "procam/core/lens/projector.hpp"
#include "procam/core/surface/scene.hpp"
#include "workers.hpp"

namespace procam::render {

class RoomSeen {
 public:
  /// The scene's surfaces in the device's frame; content is not looked at, a mask of less than one half is a
  /// hole. The scene's masks must outlive this.
  RoomSeen(const Scene& scene_in_device, const Projector& device, Workers& workers);

  /// For at() and hides(): casts at every pixel.
  void find_nearest(Workers& workers);

  /// The nearest facet at a pixel's centre, nullptr: none.
  const Facet* at(int x, int y) const {
    const Id id = nearest_[std::size_t(y) * std::size_t(lens_.grid().frame.width) + std::size_t(x)];
    return id.layer < 0 ? nullptr : &layers_[std::size_t(id.layer)].facets()[std::size_t(id.facet)];
  }
  /// The same on a ray d of the pixel, asked anew.
  const Facet* along_ray(int x, int y, const Vec3& d) const;

  /// Does anything stand before the point, by more than a thousandth of its distance? As the facets round the
  /// point's pixel tell (a pixel off at outlines at most), or exactly. The pixel must lie in the picture.
  bool hides(const Vec2& pixel, const Vec3& point) const;
  bool hides_exactly(const Vec2& pixel, const Vec3& point) const;

  const LensMap& lens() const { return lens_; }

 private:
  struct Id {
    std::int32_t layer = -1, facet = -1;
  };
  bool is_there(std::size_t layer, const Facet& facet, const Vec3& d) const;
  void find_nearest_on(int tile_x, int tile_y);

  LensMap lens_;
  std::vector<MeshLayer> layers_;
  std::vector<ViewU8> masks_;  ///< [layer]
  std::vector<Id> nearest_;
};

}  // namespace procam::render
