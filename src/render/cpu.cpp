#include "procam/render/cpu.hpp"

#include <Eigen/LU>

#include "footprint.hpp"
#include "lens_map.hpp"
#include "parallel.hpp"
#include "room_layers.hpp"

namespace procam::render {

namespace {

constexpr int kTile = 32;  ///< pixels a side of one thread's turn; as large as lens pieces usefully are

/// A scene item ready to draw.
struct Layer {
  Texture texture;
  std::optional<RoomLayer> room;           ///< of what stands in the room
  Mat3 content_from_pixel = Mat3::Zero();  ///< of a pixel surface
};

/// The inverse, scaled so that its entries are of order one (the sign kept); zero when the map is singular,
/// as for a plane through the projector.
Mat3 inverse_or_zero(const Mat3& m) {
  const double scale = m.norm();
  const double determinant = m.determinant();
  if (!(std::abs(determinant) > 1e-15 * scale * scale * scale)) return Mat3::Zero();
  const Mat3 inverse = m.inverse();
  return inverse / inverse.norm();
}

Layer make_layer(const SceneItem& item, const Projector& projector, const LightCurve& curve, int threads) {
  Layer layer{Texture(item.content, curve, threads), std::nullopt};
  if (const auto* pixels = std::get_if<PlacedPixels>(&item.placement))
    layer.content_from_pixel = inverse_or_zero(pixels->pixel_from_content);
  else if (const auto* plane = std::get_if<PlacedPlane>(&item.placement))
    layer.room.emplace(*plane, projector, kTile);
  else
    layer.room.emplace(std::get<PlacedMesh>(item.placement), projector, kTile);
  return layer;
}

/// The light of one tile while it is drawn.
struct TileLight {
  PixelRect rect;
  std::array<Rgba, kTile * kTile> light;

  Rgba& at(int x, int y) { return light[std::size_t((y - rect.y0) * kTile + (x - rect.x0))]; }
};

void draw_pixel(const Texture& texture, const Footprint& footprint, bool whole, Rgba& light) {
  Coverage covered;
  if (!whole) {
    whole = true;
    for (const Eigen::RowVector3d& border : border_combinations()) {
      const double side = border * footprint.centre;
      const double reach =
          0.5 * (std::abs(border * footprint.slope_x) + std::abs(border * footprint.slope_y));
      if (side <= -reach) return;
      whole = whole && side >= reach;
    }
    if (!whole) covered = coverage(footprint);
    if (covered.area == 0) return;
  }
  const Rgba content = float(covered.area) * mean_content(texture, footprint, whole, covered.centroid);
  light = content + (1 - content[3]) * light;
}

/// Draws the part of a plane that falls on a rectangle with known homogeneous content coordinates.
void draw_piece(const Texture& texture, const PixelRect& rect, const Patch& q, TileLight& tile) {
  bool whole = true;
  for (const Eigen::RowVector3d& border : border_combinations()) {
    const Patch::Bounds bounds = q.bounds(border);
    if (!(bounds.high > 0)) return;
    whole = whole && bounds.low > 0;
  }
  const double ds = 2.0 / rect.width(), dt = 2.0 / rect.height();  // a pixel's step in s and t
  for (int y = rect.y0; y < rect.y1; ++y) {
    const Quadratic3 row = q.row(rect.t(y)), down = q.row_slope(rect.t(y));
    for (int x = rect.x0; x < rect.x1; ++x) {
      const double s = rect.s(x);
      const Footprint footprint{row[0] + s * (row[1] + s * row[2]), ds * (row[1] + 2 * s * row[2]),
                                dt * (down[0] + s * (down[1] + s * down[2]))};
      draw_pixel(texture, footprint, whole, tile.at(x, y));
    }
  }
}

/// Can any of the plane's content be on the pieces?
bool touches(const Facet& plane, const std::vector<LensPiece>& pieces) {
  for (const LensPiece& piece : pieces) {
    bool on_piece = true;
    for (const Vec3& border : plane.borders)
      on_piece = on_piece && piece.direction_from_pixel.bounds(border.transpose()).high > 0;
    if (on_piece) return true;
  }
  return false;
}

/// Does plane `a` hide the later plane `b` all over the pieces (true), or b a (false, also where they lie
/// together)? nullopt: now this, now that.
std::optional<bool> hides(const Facet& a, const Facet& b, const std::vector<LensPiece>& pieces) {
  const Eigen::RowVector3d ahead = ((1 - kTogether) * a.nearness - b.nearness).transpose();
  bool somewhere = false, not_somewhere = false;
  for (const LensPiece& piece : pieces) {
    const Patch::Bounds bounds = piece.direction_from_pixel.bounds(ahead);
    somewhere = somewhere || bounds.high > 0;
    not_somewhere = not_somewhere || bounds.low <= 0;
  }
  if (somewhere && not_somewhere) return std::nullopt;
  return somewhere;
}

/// Draws what stands in the room, `items` in the scene's order.
void draw_room(const std::vector<RoomItem>& items, int turn, const std::vector<LensPiece>& pieces,
               TileLight& tile) {
  std::vector<RoomItem> back_to_front;
  bool ordered = true;
  for (const RoomItem& item : items) {
    if (item.layer->boxes(turn).empty()) continue;
    if (!item.layer->is_plane()) {
      ordered = false;
    } else if (!touches(item.layer->facets()[0], pieces)) {
      continue;
    }
    back_to_front.push_back(item);
  }
  const std::vector<RoomItem> touching = back_to_front;
  for (std::size_t i = 1; ordered && i < back_to_front.size(); ++i)
    for (std::size_t j = i; ordered && j > 0; --j) {
      RoomItem &before = back_to_front[j - 1], &item = back_to_front[j];
      const auto hidden = hides(before.layer->facets()[0], item.layer->facets()[0], pieces);
      ordered = hidden.has_value();
      if (!ordered || !*hidden) break;
      std::swap(before, item);
    }
  if (!ordered) return draw_cast(touching, turn, tile.rect, pieces, tile.light.data(), kTile);
  for (const RoomItem& item : back_to_front)
    for (const LensPiece& piece : pieces)
      draw_piece(*item.texture, piece.rect,
                 item.layer->facets()[0].content_from_direction * piece.direction_from_pixel, tile);
}

void require_drawable(const Scene& scene, const Projector& projector, ImageView<std::uint8_t> frame) {
  require(frame.channels == 3 && frame.size() == projector.size() && !frame.empty(),
          "render: the frame must have 3 channels and the projector's size");
  for (const SceneItem& item : scene.items) {
    const int channels = item.content.channels;
    require(!item.content.empty() && (channels == 1 || channels == 3 || channels == 4),
            "render: content must be a picture with 1, 3 or 4 channels, not " +
                std::to_string(item.content.width) + "x" + std::to_string(item.content.height) + " with " +
                std::to_string(channels));
  }
}

}  // namespace

void render(const Scene& scene, const Projector& projector, ImageView<std::uint8_t> frame,
            const RenderOptions& options) {
  require_drawable(scene, projector, frame);
  const LightCurve curve(options.linear_light);
  std::vector<Layer> layers;
  bool any_through_lens = false;
  for (const SceneItem& item : scene.items) {
    layers.push_back(make_layer(item, projector, curve, options.threads));
    any_through_lens = any_through_lens || layers.back().room;
  }
  const Rgba background(curve.light(scene.background[0]), curve.light(scene.background[1]),
                        curve.light(scene.background[2]), 1);

  const int tiles_across = (frame.width + kTile - 1) / kTile, tiles_down = (frame.height + kTile - 1) / kTile;
  parallel_for(tiles_across * tiles_down, options.threads, [&](int turn) {
    const int x0 = turn % tiles_across * kTile, y0 = turn / tiles_across * kTile;
    TileLight tile{{x0, y0, std::min(x0 + kTile, frame.width), std::min(y0 + kTile, frame.height)}, {}};
    tile.light.fill(background);

    std::vector<LensPiece> pieces;
    if (any_through_lens) pieces = lens_pieces(projector, tile.rect);
    const Patch pixels = Patch::of_pixels(tile.rect);
    std::vector<RoomItem> together;  // in the room, between two pixel surfaces
    for (const Layer& layer : layers) {
      if (layer.room) {
        together.push_back({&*layer.room, &layer.texture});
        continue;
      }
      draw_room(together, turn, pieces, tile);
      together.clear();
      draw_piece(layer.texture, tile.rect, layer.content_from_pixel * pixels, tile);
    }
    draw_room(together, turn, pieces, tile);

    for (int y = tile.rect.y0; y < tile.rect.y1; ++y) {
      std::uint8_t* to = frame.row(y) + std::ptrdiff_t(x0) * 3;
      for (int x = x0; x < tile.rect.x1; ++x)
        for (int channel = 0; channel < 3; ++channel) *to++ = curve.value(tile.at(x, y)[channel]);
    }
  });
}

ImageU8 render(const Scene& scene, const Projector& projector, const RenderOptions& options) {
  ImageU8 frame(projector.size(), 3);
  render(scene, projector, frame.view(), options);
  return frame;
}

}  // namespace procam::render
