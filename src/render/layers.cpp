#include "layers.hpp"

#include <Eigen/LU>

#include "mesh_tile.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/render/cpu.hpp"

namespace procam::render {

namespace {

/// The inverse, scaled so that its entries are of order one (the sign kept); zero when the map is singular,
/// as for a plane through the projector.
Mat3 inverse_or_zero(const Mat3& m) {
  const double scale = m.norm();
  const double determinant = m.determinant();
  if (!(std::abs(determinant) > 1e-15 * scale * scale * scale)) return Mat3::Zero();
  const Mat3 inverse = m.inverse();
  return inverse / inverse.norm();
}

PlaneView view_of(const PlacedPixels& pixels, const SceneItem& shown) {
  return {inverse_or_zero(pixels.pixel_from_content), false, shown.content.size(), shown.mask.size()};
}
PlaneView view_of(const PlacedPlane& plane, const SceneItem& shown) {
  Mat3 direction_from_plane = plane.projector_from_surface.rotation_matrix();
  direction_from_plane.col(2) = plane.projector_from_surface.translation;
  return {inverse_or_zero(direction_from_plane * plane.plane_from_content), true, shown.content.size(),
          shown.mask.size()};
}

/// Does plane `a` hide the later plane `b` all over the pieces (true), or b a (false, also where they lie
/// together)? nullopt: now this, now that.
std::optional<bool> hides(const Facet& a, const Facet& b, const std::vector<LensPiece>& pieces) {
  Eigen::RowVector3d ahead;
  for (int k = 0; k < 3; ++k)
    ahead[k] = (1 - double(kCoplanarTolerance)) * double(a.nearness[k]) - double(b.nearness[k]);
  bool somewhere = false, not_somewhere = false;
  for (const LensPiece& piece : pieces) {
    const auto [low, high] = bounds(ahead, piece.direction_from_pixel.bernstein());
    somewhere = somewhere || high > 0;
    not_somewhere = not_somewhere || low <= 0;
  }
  if (somewhere && not_somewhere) return std::nullopt;
  return somewhere;
}

}  // namespace

void require_drawable(ImageSize frame) {
  if (std::max(frame.width, frame.height) <= limits::kFrameSide) return;
  throw Error(
      ErrorKind::kInput, "frame",
      "the projector has " + std::to_string(frame.width) + " x " + std::to_string(frame.height) + " pixels",
      "give one of at most " + std::to_string(limits::kFrameSide) + " pixels a side");
}

void require_drawable(const Scene& scene, ImageSize frame) {
  require_drawable(frame);
  const auto require_size = [](ViewU8 view, const char* what) {
    if (std::int64_t(view.width) * view.height > limits::kContentPixels)
      throw Error(ErrorKind::kInput, what,
                  "it has " + std::to_string(view.width) + " x " + std::to_string(view.height) + " pixels",
                  "give a picture of at most " + std::to_string(limits::kContentPixels) + " pixels");
  };
  for (const SceneItem& item : scene.items) {
    require_size(item.content, "content");
    require_size(item.mask, "mask");
    const int channels = item.content.channels;
    if (!item.mask.empty() && item.mask.channels != 1)
      throw std::invalid_argument("render: a mask must have one channel, not " +
                                  std::to_string(item.mask.channels));
    if (!item.content.empty() && (channels == 1 || channels == 3 || channels == 4)) continue;
    throw std::invalid_argument("render: content must be a picture with 1, 3 or 4 channels, not " +
                                std::to_string(item.content.width) + "x" +
                                std::to_string(item.content.height) + " with " + std::to_string(channels));
  }
}

bool same_view(ViewU8 a, ViewU8 b) {
  return a.data == b.data && a.size() == b.size() && a.channels == b.channels && a.stride == b.stride;
}

ViewU8 as_alpha(ViewU8 mask, std::vector<std::uint8_t>& memory) {
  memory.assign(4 * std::size_t(mask.width) * std::size_t(mask.height), 0);
  std::uint8_t* to = memory.data() + 3;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x, to += 4) *to = mask.at(x, y);
  return {memory.data(), mask.width, mask.height, 4};
}

bool Layer::place(const SceneItem& shown, const Projector& projector, const LensMap& lens, bool same_lens,
                  bool area, Workers& workers) {
  if (const auto* pixels = std::get_if<PlacedPixels>(&shown.placement); pixels && pixels->mesh)
    return place_in_pixels(*pixels, projector, lens, same_lens, workers);
  in_pixels_.reset();
  if (const auto* placed = std::get_if<PlacedMesh>(&shown.placement)) {
    const Pose &a = placed->projector_from_surface, &b = mesh_.projector_from_surface;
    if (same_lens && is_mesh() && placed->mesh == mesh_.mesh && a.translation == b.translation &&
        a.rotation.coeffs() == b.rotation.coeffs() && placed->content_from_point == mesh_.content_from_point)
      return false;
    if (is_mesh())
      room->move(*placed, projector, lens.grid(), workers);
    else
      room.emplace(*placed, projector, lens.grid(), workers);
    mesh_ = *placed;
    ++made;
    return true;
  }
  const auto* placed = std::get_if<PlacedPlane>(&shown.placement);
  const PlaneView view =
      placed ? view_of(*placed, shown) : view_of(std::get<PlacedPixels>(shown.placement), shown);
  const bool was_mesh = is_mesh();  // of which the plane's map, as it was, knows nothing
  const bool moved = plane.update(view, lens, same_lens, area, workers) || was_mesh;
  made += moved;
  if (!placed)
    room.reset();
  else if (moved || !room || is_mesh())
    room.emplace(*placed, lens.grid());
  return moved;
}

/// As triangles on the rays of their pixels. The same mesh before the same lens stays.
bool Layer::place_in_pixels(const PlacedPixels& placed, const Projector& projector, const LensMap& lens,
                            bool same_lens, Workers& workers) {
  if (same_lens && is_mesh() && in_pixels_ == placed.mesh) return false;
  const PlacedMesh lit = mesh_on_rays(placed, projector);
  if (is_mesh())
    room->move(lit, projector, lens.grid(), workers);
  else
    room.emplace(lit, projector, lens.grid(), workers);
  mesh_ = lit;
  in_pixels_ = placed.mesh;
  ++made;
  return true;
}

const std::vector<int>& TileSteps::find(const std::vector<Layer>& layers, const LensMap& lens, int tile_x,
                                        int tile_y) {
  steps_.clear();
  group_.clear();
  for (std::size_t i = 0; i < layers.size(); ++i) {
    if (!layers[i].touches(tile_x, tile_y)) continue;
    if (layers[i].room && !layers[i].is_in_pixels()) {
      group_.push_back(int(i));
      continue;
    }
    add_group(layers, lens, tile_x, tile_y);
    if (layers[i].is_mesh()) {  // by itself: it hides nothing by depth
      group_.push_back(int(i));
      add_group(layers, lens, tile_x, tile_y);
    } else {
      steps_.push_back(int(i));
    }
  }
  add_group(layers, lens, tile_x, tile_y);
  return steps_;
}

/// The group's steps: its planes by depth, or a cast. Empties it.
void TileSteps::add_group(const std::vector<Layer>& layers, const LensMap& lens, int x, int y) {
  constexpr int kDrawn = -1;
  const std::size_t count = group_.size();
  const auto is_mesh = [&](int item) { return layers[std::size_t(item)].is_mesh(); };
  bool ordered = std::none_of(group_.begin(), group_.end(), is_mesh) && find_order(layers, lens, x, y);
  const auto must_wait = [&](std::size_t i) {
    for (std::size_t j = 0; j < count; ++j)
      if (group_[j] != kDrawn && j != i &&
          order_[std::max(i, j) * count + std::min(i, j)] == (j > i ? 1 : -1))
        return true;
    return false;
  };
  for (std::size_t left = count; ordered && left > 0; --left) {
    // The first in the scene's order that nothing left must come before. There is none where planes lie
    // over each other in a ring.
    std::size_t next = 0;
    while (next < count && (group_[next] == kDrawn || must_wait(next))) ++next;
    ordered = next < count;
    if (!ordered) break;
    steps_.push_back(group_[next]);
    group_[next] = kDrawn;
  }
  if (!ordered) {
    steps_.push_back(kCast);
    for (const int item : group_)
      if (item != kDrawn) steps_.push_back(item);
    steps_.push_back(kCast);
  }
  group_.clear();
}

/// Which of each two overlapping planes is drawn first; false where that is not the same all over the tile.
bool TileSteps::find_order(const std::vector<Layer>& layers, const LensMap& lens, int x, int y) {
  const std::size_t count = group_.size();
  order_.assign(count * count, 0);
  for (std::size_t later = 1; later < count; ++later)
    for (std::size_t earlier = 0; earlier < later; ++earlier) {
      const Layer &a = layers[std::size_t(group_[earlier])], &b = layers[std::size_t(group_[later])];
      if (!a.plane.overlaps(b.plane, x, y)) continue;
      const auto hidden = hides(a.room->facets()[0], b.room->facets()[0], lens.pieces(x, y));
      if (!hidden) return false;
      order_[later * count + earlier] = *hidden ? 1 : -1;
    }
  return true;
}

}  // namespace procam::render
