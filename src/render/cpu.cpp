#include "procam/render/cpu.hpp"

#include <Eigen/LU>

#include "footprint.hpp"
#include "lens_map.hpp"
#include "parallel.hpp"

namespace procam::render {

namespace {

constexpr int kTile = 32;  ///< pixels a side of one thread's turn; as large as lens pieces usefully are

/// A scene item ready to draw.
struct Layer {
  Texture texture;
  bool through_lens;            ///< rays (planes) or pixel positions (pixel surfaces)
  Mat3 content_from_direction;  ///< q = M d; zero where nothing can be drawn (edge-on)
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

Layer make_layer(const SceneItem& item, const LightCurve& curve, int threads) {
  Layer layer{Texture(item.content, curve, threads), false, Mat3::Zero()};
  if (const auto* pixels = std::get_if<PlacedPixels>(&item.placement)) {
    layer.content_from_direction = inverse_or_zero(pixels->pixel_from_content);
  } else {
    const PlacedPlane& plane = std::get<PlacedPlane>(item.placement);
    Mat3 direction_from_plane = plane.projector_from_surface.rotation_matrix();
    direction_from_plane.col(2) = plane.projector_from_surface.translation;
    layer.through_lens = true;
    layer.content_from_direction = inverse_or_zero(direction_from_plane * plane.plane_from_content);
  }
  return layer;
}

/// The light of one tile while it is drawn.
struct TileLight {
  PixelRect rect;
  std::array<Rgba, kTile * kTile> light;

  Rgba& at(int x, int y) { return light[std::size_t((y - rect.y0) * kTile + (x - rect.x0))]; }
};

void draw_pixel(const Layer& layer, const Footprint& footprint, bool whole, Rgba& light) {
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
  const Rgba content = float(covered.area) * mean_content(layer.texture, footprint, whole, covered.centroid);
  light = content + (1 - content[3]) * light;
}

/// Draws the part of a layer that falls on a rectangle with known directions.
void draw_piece(const Layer& layer, const PixelRect& rect, const Patch& direction_from_pixel,
                TileLight& tile) {
  const Patch q = layer.content_from_direction * direction_from_pixel;
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
      draw_pixel(layer, footprint, whole, tile.at(x, y));
    }
  }
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
    layers.push_back(make_layer(item, curve, options.threads));
    any_through_lens = any_through_lens || layers.back().through_lens;
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
    for (const Layer& layer : layers) {
      if (!layer.through_lens) draw_piece(layer, tile.rect, pixels, tile);
      for (const LensPiece& piece : pieces)
        if (layer.through_lens) draw_piece(layer, piece.rect, piece.direction_from_pixel, tile);
    }

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
