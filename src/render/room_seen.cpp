#include "room_seen.hpp"

#include <cmath>
#include <limits>

#include "mesh_tile.hpp"

namespace procam::render {

RoomSeen::RoomSeen(const Scene& scene_in_device, const Projector& device, Workers& workers) {
  lens_.update(device, workers);
  const TileGrid grid = lens_.grid();
  for (const SceneItem& item : scene_in_device.items) {
    if (const auto* plane = std::get_if<PlacedPlane>(&item.placement))
      layers_.emplace_back(*plane, grid);
    else if (const auto* mesh = std::get_if<PlacedMesh>(&item.placement))
      layers_.emplace_back(*mesh, device, grid, workers);
    else
      continue;
    masks_.push_back(item.mask);
  }
}

void RoomSeen::find_nearest(Workers& workers) {
  const TileGrid grid = lens_.grid();
  nearest_.resize(std::size_t(grid.frame.width) * std::size_t(grid.frame.height));
  workers.run(grid.down(), [&](int y) {
    for (int x = 0; x < grid.across(); ++x) find_nearest_on(x, y);
  });
}

void RoomSeen::find_nearest_on(int tile_x, int tile_y) {
  const PixelRect rect = lens_.grid().tile(tile_x, tile_y);
  Rays rays;
  std::fill(std::begin(rays.x), std::end(rays.x), std::numeric_limits<float>::quiet_NaN());
  for (const LensPiece& piece : lens_.pieces(tile_x, tile_y)) {
    const PixelRect& r = piece.rect;
    for (int y = r.y0; y < r.y1; ++y) {
      const Quadratic3 row = piece.direction_from_pixel.row(r.t(y));
      for (int x = r.x0; x < r.x1; ++x) {
        const double s = r.s(x);
        const Vec3 d = row[0] + s * (row[1] + s * row[2]);
        const int at = ray_place(x - rect.x0, y - rect.y0);
        rays.x[at] = float(d.x());
        rays.y[at] = float(d.y());
        rays.z[at] = float(d.z());
      }
    }
  }
  const Kernels& kernels = best_kernels();
  Hits hits;
  std::vector<float> nearness(kRayRoom, 0.0f);
  for (std::size_t layer = 0; layer < layers_.size(); ++layer) {
    std::fill(std::begin(hits.nearness), std::end(hits.nearness), 0.0f);
    std::fill(std::begin(hits.facet), std::end(hits.facet), -1);
    const FacetBoxes boxes = layers_[layer].boxes(tile_x, tile_y);
    kernels.cast(layers_[layer].facets().data(), layers_[layer].borders(), boxes.data, boxes.count, rect.x0,
                 rect.y0, rays, hits);
    for (int y = 0; y < rect.height(); ++y)
      for (int x = 0; x < rect.width(); ++x) {
        const int at = ray_place(x, y);
        if (hits.facet[at] < 0 || !(hits.nearness[at] > nearness[std::size_t(at)])) continue;
        const Vec3 d(double(rays.x[at]), double(rays.y[at]), double(rays.z[at]));
        if (!is_there(layer, layers_[layer].facets()[std::size_t(hits.facet[at])], d)) continue;
        nearness[std::size_t(at)] = hits.nearness[at];
        nearest_[std::size_t(rect.y0 + y) * std::size_t(lens_.grid().frame.width) +
                 std::size_t(rect.x0 + x)] = {std::int32_t(layer), hits.facet[at]};
      }
  }
}

bool RoomSeen::is_there(std::size_t layer, const Facet& facet, const Vec3& d) const {
  const ViewU8& mask = masks_[layer];
  if (mask.empty()) return true;
  const Vec3 q(double(along(facet.content[0], d)), double(along(facet.content[1], d)),
               double(along(facet.content[2], d)));
  const auto texel = [&](double share, int count) {
    return int(std::min(std::max(share * count, 0.0), count - 1.0));
  };
  return q.z() > 0 && mask.at(texel(q.x() / q.z(), mask.width), texel(q.y() / q.z(), mask.height)) >= 128;
}

const Facet* RoomSeen::along_ray(int x, int y, const Vec3& d) const {
  const Facet* found = nullptr;
  for (std::size_t layer = 0; layer < layers_.size(); ++layer) {
    const Facet* facet = layers_[layer].nearest(x, y, d);
    if (facet && (!found || along(facet->nearness, d) > along(found->nearness, d)) &&
        is_there(layer, *facet, d))
      found = facet;
  }
  return found;
}

namespace {
bool is_before(const Facet* facet, const Vec3& point) {
  return facet && along(facet->nearness, point) > 1 + kCoplanarTolerance;  // 1: the point lies on it
}
}  // namespace

bool RoomSeen::hides(const Vec2& pixel, const Vec3& point) const {
  const ImageSize size = lens_.grid().frame;
  const int x = int(std::floor(pixel.x())), y = int(std::floor(pixel.y()));
  for (int dy = 0; dy < 2; ++dy)
    for (int dx = 0; dx < 2; ++dx)
      if (!is_before(at(std::min(std::max(x + dx, 0), size.width - 1),
                        std::min(std::max(y + dy, 0), size.height - 1)),
                     point))
        return false;
  return true;
}

bool RoomSeen::hides_exactly(const Vec2& pixel, const Vec3& point) const {
  const ImageSize size = lens_.grid().frame;
  const int x = std::min(std::max(int(std::lround(pixel.x())), 0), size.width - 1),
            y = std::min(std::max(int(std::lround(pixel.y())), 0), size.height - 1);
  return is_before(along_ray(x, y, point), point);
}

}  // namespace procam::render
