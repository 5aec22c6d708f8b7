#include "procam/render/cpu.hpp"

#include <Eigen/LU>
#include <cstring>

#include "plane_layer.hpp"

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

PlaneView view_of(const SceneItem& item) {
  if (const auto* pixels = std::get_if<PlacedPixels>(&item.placement))
    return {inverse_or_zero(pixels->pixel_from_content), false, item.content.size()};
  const PlacedPlane& plane = std::get<PlacedPlane>(item.placement);
  Mat3 direction_from_plane = plane.projector_from_surface.rotation_matrix();
  direction_from_plane.col(2) = plane.projector_from_surface.translation;
  return {inverse_or_zero(direction_from_plane * plane.plane_from_content), true, item.content.size()};
}

void require_drawable(const Scene& scene, const Projector& projector, ImageView<std::uint8_t> frame) {
  if (!(frame.channels == 3 && frame.size() == projector.size() && !frame.empty()))
    throw std::invalid_argument("render: the frame must have 3 channels and the projector's size");
  for (const SceneItem& item : scene.items) {
    const int channels = item.content.channels;
    if (!item.content.empty() && (channels == 1 || channels == 3 || channels == 4)) continue;
    throw std::invalid_argument("render: content must be a picture with 1, 3 or 4 channels, not " +
                                std::to_string(item.content.width) + "x" +
                                std::to_string(item.content.height) + " with " + std::to_string(channels));
  }
}

bool same_view(ViewU8 a, ViewU8 b) {
  return a.data == b.data && a.size() == b.size() && a.channels == b.channels && a.stride == b.stride;
}

void to_frame(const Kernels& kernels, const LightCurve&, const Value* from, int count, std::uint8_t* to) {
  kernels.values_to_rgb(from, count, to);
}
void to_frame(const Kernels&, const LightCurve& curve, const Light* from, int count, std::uint8_t* to) {
  for (int i = 0; i < count; ++i, from += 4)
    for (int k = 0; k < 3; ++k) *to++ = curve.value(from[k]);
}

}  // namespace

/// Filled from back to front, a tile of the frame at a time.
class CpuRenderer::State {
 public:
  explicit State(const RenderOptions& options)
      : options_(options),
        kernels_(options.wide_vectors ? best_kernels() : kPlainKernels),
        curve_(options.linear_light),
        workers_(options.threads) {}

  RenderWork render(const Scene& scene, const Projector& projector, ImageView<std::uint8_t> frame) {
    require_drawable(scene, projector, frame);
    const RenderWork work = prepare(scene, projector);
    const auto band = [&](int y) {
      if (values_only())
        draw_band<ValueTexture>(y, scene, frame);
      else
        draw_band<LightTexture>(y, scene, frame);
    };
    workers_.run(lens_.grid().down(), band);
    return work;
  }

 private:
  struct Item {
    ViewU8 picture;
    std::uint64_t revision = 0;
    LightTexture light;  ///< this or the other, see values_only()
    ValueTexture values;
    PlaneLayer layer;

    template <typename Texture>
    const Texture& texture() const {
      if constexpr (std::is_same_v<Texture, LightTexture>)
        return light;
      else
        return values;
    }
  };

  /// Plain interpolation of values needs no more than 8 bits.
  bool values_only() const { return options_.filter == Filter::kBilinear && !options_.linear_light; }

  RenderWork prepare(const Scene& scene, const Projector& projector) {
    const bool same_lens = !lens_.update(projector, workers_);
    items_.resize(scene.items.size());
    RenderWork work;
    for (std::size_t i = 0; i < items_.size(); ++i) {
      const SceneItem& shown = scene.items[i];
      Item& item = items_[i];
      work.maps +=
          item.layer.update(view_of(shown), lens_, same_lens, options_.filter == Filter::kArea, workers_);
      const int levels = item.layer.levels();
      if (same_view(shown.content, item.picture) && shown.content_revision == item.revision &&
          (values_only() || levels <= item.light.levels()))
        continue;
      item.picture = shown.content;
      item.revision = shown.content_revision;
      if (values_only())
        item.values.prepare(item.picture, workers_);
      else
        item.light.prepare(item.picture, curve_, levels, workers_);
      ++work.contents;
    }
    return work;
  }

  template <typename Texture>
  void draw_band(int y, const Scene& scene, ImageView<std::uint8_t> frame) const {
    using Pixel = typename Texture::Pixel;
    Tile<Pixel> tile;
    tile.y = y;
    for (tile.x = 0; tile.x < lens_.grid().across(); ++tile.x) {
      tile.rect = lens_.grid().tile(tile.x, y);
      fetch_ahead(tile.rect, frame);
      // From the topmost that hides all below it.
      std::size_t first = items_.size();
      while (first > 0 && !hides<Texture>(items_[first - 1], tile.x, y)) --first;
      if (first == 0)
        fill(scene.background, tile);
      else
        --first;
      for (std::size_t i = first; i < items_.size(); ++i)
        items_[i].layer.draw(items_[i].template texture<Texture>(), kernels_, tile);
      for (int row = 0; row < tile.rect.height(); ++row)
        to_frame(kernels_, curve_, tile.row(row), tile.rect.width(),
                 frame.row(tile.rect.y0 + row) + std::ptrdiff_t(tile.rect.x0) * 3);
    }
  }

  /// Asks for the memory that will be written when the tile is drawn.
  static void fetch_ahead(const PixelRect& rect, ImageView<std::uint8_t> frame) {
    constexpr int kLine = 64;  // bytes
    for (int y = rect.y0; y < rect.y1; ++y) {
      const std::uint8_t* const row = frame.row(y);
      for (int i = rect.x0 * 3; i < rect.x1 * 3; i += kLine) __builtin_prefetch(row + i, 1);
    }
  }

  template <typename Texture>
  static bool hides(const Item& item, int tile_x, int tile_y) {
    return item.template texture<Texture>().opaque() && item.layer.covers(tile_x, tile_y);
  }

  template <typename Pixel>
  void fill(const std::uint8_t* background, Tile<Pixel>& tile) const {
    Pixel colour[4];
    for (int k = 0; k < 3; ++k) {
      if constexpr (std::is_same_v<Pixel, Light>)
        colour[k] = curve_.light(background[k]);
      else
        colour[k] = background[k];
    }
    colour[3] = std::is_same_v<Pixel, Light> ? Pixel(kFull) : Pixel(255);
    for (std::size_t i = 0; i < tile.pixels.size(); i += 4) std::copy_n(colour, 4, &tile.pixels[i]);
  }

  RenderOptions options_;
  const Kernels& kernels_;
  LightCurve curve_;
  Workers workers_;
  LensMap lens_;
  std::vector<Item> items_;
};

CpuRenderer::CpuRenderer(const RenderOptions& options) : state_(std::make_unique<State>(options)) {}
CpuRenderer::CpuRenderer(CpuRenderer&&) noexcept = default;
CpuRenderer& CpuRenderer::operator=(CpuRenderer&&) noexcept = default;
CpuRenderer::~CpuRenderer() = default;

RenderWork CpuRenderer::render(const Scene& scene, const Projector& projector,
                               ImageView<std::uint8_t> frame) {
  return state_->render(scene, projector, frame);
}

void render(const Scene& scene, const Projector& projector, ImageView<std::uint8_t> frame,
            const RenderOptions& options) {
  CpuRenderer(options).render(scene, projector, frame);
}

ImageU8 render(const Scene& scene, const Projector& projector, const RenderOptions& options) {
  ImageU8 frame(projector.size(), 3);
  render(scene, projector, frame.view(), options);
  return frame;
}

}  // namespace procam::render
