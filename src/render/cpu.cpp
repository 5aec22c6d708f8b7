#include "procam/render/cpu.hpp"

#include "layers.hpp"
#include "mesh_tile.hpp"

namespace procam::render {

namespace {

void to_frame(const Kernels& kernels, const LightCurve&, const Value* from, int count, std::uint8_t* to) {
  kernels.values_to_rgb(from, count, to);
}
void to_frame(const Kernels&, const LightCurve& curve, const Light* from, int count, std::uint8_t* to) {
  for (int i = 0; i < count; ++i, from += 4)
    for (int k = 0; k < 3; ++k) *to++ = curve.value(from[k]);
}
/// Light, or numbers as they stand, as shares of the whole.
void to_frame(const Kernels&, const LightCurve&, const Value* from, int count, float* to) {
  for (int i = 0; i < count; ++i, from += 4)
    for (int k = 0; k < 3; ++k) *to++ = float(from[k]) / 255.0f;
}
void to_frame(const Kernels&, const LightCurve&, const Light* from, int count, float* to) {
  for (int i = 0; i < count; ++i, from += 4)
    for (int k = 0; k < 3; ++k) *to++ = float(from[k]) / float(kFull);
}

}  // namespace

/// A tile of the frame at a time is filled from back to front.
class CpuRenderer::State {
 public:
  explicit State(const RenderOptions& options)
      : options_(options),
        kernels_(kernels_for(options.vector_bits)),
        curve_(options.linear_light),
        workers_(options.threads) {}

  template <typename Number>
  RenderWork render(const Scene& scene, const Projector& projector, ImageView<Number> frame) {
    if (!(frame.channels == 3 && frame.size() == projector.size() && !frame.empty()))
      throw std::invalid_argument("render: the frame must have 3 channels and the projector's size");
    require_drawable(scene, projector.size());
    const RenderWork work = prepare(scene, projector);
    workers_.run(lens_.grid().down(), [&](int y) {
      if (values_only())
        draw_band<ValueTexture>(y, scene, frame);
      else
        draw_band<LightTexture>(y, scene, frame);
    });
    return work;
  }

 private:
  /// A picture, ready to be sampled.
  struct Shown {
    ViewU8 view;
    std::uint64_t revision = 0;
    LightTexture light;  ///< this or the other, see values_only()
    ValueTexture values;

    template <typename Texture>
    const Texture& texture() const {
      if constexpr (std::is_same_v<Texture, LightTexture>)
        return light;
      else
        return values;
    }
    int levels() const { return std::max(1, light.levels()); }
  };
  struct Item {
    Shown picture, mask;

    template <typename Texture>
    ItemTextures<Texture> textures() const {
      return {&picture.texture<Texture>(), mask.view.empty() ? nullptr : &mask.texture<Texture>()};
    }
  };

  /// What is worked out for a tile; one a band, kept from frame to frame.
  struct Plan {
    TileSteps steps;
    std::vector<CastItem> cast;
    MeshCaster caster;
    MeshTile moving;
    std::vector<ItemTextures<LightTexture>> lights;
    std::vector<ItemTextures<ValueTexture>> values;
    RoomRows<Light> light_rows;
    RoomRows<Value> value_rows;
    std::vector<std::vector<MeshTile>> tiles;  ///< [tile, cast]
  };

  bool area() const { return options_.filter == Filter::kArea; }
  /// Plain interpolation of values needs no more than 8 bits.
  bool values_only() const { return !area() && !options_.linear_light; }

  RenderWork prepare(const Scene& scene, const Projector& projector) {
    const bool same_lens = !lens_.update(projector, workers_);
    if (!same_lens) plans_.clear();
    plans_.resize(std::size_t(lens_.grid().down()));
    for (Plan& plan : plans_) plan.tiles.resize(std::size_t(lens_.grid().across()));
    items_.resize(scene.items.size());
    layers_.resize(scene.items.size());
    RenderWork work;
    for (std::size_t i = 0; i < items_.size(); ++i) {
      const SceneItem& shown = scene.items[i];
      Item& item = items_[i];
      work.maps += layers_[i].place(shown, projector, lens_, same_lens, area(), workers_);
      work.contents += prepare(
          shown.content, shown.content_revision, layers_[i].levels(shown.content.size()),
          [](ViewU8 view) { return view; }, item.picture);
      if (!shown.mask.empty())
        work.contents += prepare(
            shown.mask, shown.mask_revision, layers_[i].mask_levels(shown.mask.size()),
            [&](ViewU8 view) { return as_alpha(view, alpha_); }, item.mask);
      else
        item.mask.view = {};
    }
    return work;
  }

  /// Returns whether anything had to be made.
  template <typename Convert>
  bool prepare(ViewU8 view, std::uint64_t revision, int levels, const Convert& convert, Shown& ready) {
    if (same_view(view, ready.view) && revision == ready.revision &&
        (values_only() || levels <= ready.light.levels()))
      return false;
    ready.view = view;
    ready.revision = revision;
    if (values_only())
      ready.values.prepare(convert(view), kernels_, workers_);
    else
      ready.light.prepare(convert(view), curve_, levels, workers_);
    return true;
  }

  template <typename Texture, typename Number>
  void draw_band(int y, const Scene& scene, ImageView<Number> frame) {
    Plan& plan = plans_[std::size_t(y)];
    Tile<typename Texture::Pixel> tile;
    tile.y = y;
    for (tile.x = 0; tile.x < lens_.grid().across(); ++tile.x) {
      tile.rect = lens_.grid().tile(tile.x, y);
      fetch_ahead(tile.rect, frame);
      const std::vector<int>& steps = plan.steps.find(layers_, lens_, tile.x, y);
      std::size_t first = 0, casts = 0;
      if (!find_first<Texture>(steps, tile.x, y, first)) fill(scene.background, tile);
      for (std::size_t i = first; i < steps.size(); ++i) {
        const auto item = std::size_t(steps[i]);
        if (steps[i] == TileSteps::kCast) {
          i = cast({steps, i + 1, casts++}, plan, tile);
          continue;
        }
        const ItemTextures<Texture> textures = items_[item].template textures<Texture>();
        layers_[item].plane.draw(*textures.content, textures.mask, kernels_, tile);
      }
      for (int row = 0; row < tile.rect.height(); ++row)
        to_frame(kernels_, curve_, tile.row(row), tile.rect.width(),
                 frame.row(tile.rect.y0 + row) + std::ptrdiff_t(tile.rect.x0) * 3);
    }
  }

  /// The topmost step that hides all below it; false when there is none.
  template <typename Texture>
  bool find_first(const std::vector<int>& steps, int x, int y, std::size_t& first) const {
    bool in_cast = false;
    for (std::size_t i = steps.size(); i-- > 0;) {
      const auto item = std::size_t(steps[i]);
      if (steps[i] == TileSteps::kCast) {
        in_cast = !in_cast;
      } else if (!in_cast && items_[item].textures<Texture>().opaque() && layers_[item].plane.covers(x, y)) {
        first = i;
        return true;
      }
    }
    return false;
  }

  /// The `n`-th cast of a tile, which begins at step `first`.
  struct TileCast {
    const std::vector<int>& steps;
    std::size_t first, n;
  };
  /// Draws it; its kCast's place is returned.
  template <typename Texture>
  std::size_t draw_cast(const TileCast& tile_cast, std::vector<ItemTextures<Texture>>& textures,
                        RoomRows<typename Texture::Pixel>& rows, Plan& plan,
                        Tile<typename Texture::Pixel>& tile) const {
    auto [steps, first, n] = tile_cast;
    plan.cast.clear();
    textures.clear();
    for (; steps[first] != TileSteps::kCast; ++first) {
      const auto item = std::size_t(steps[first]);
      const Shown &picture = items_[item].picture, &mask = items_[item].mask;
      textures.push_back(items_[item].template textures<Texture>());
      plan.cast.push_back({&*layers_[item].room, layers_[item].made, picture.view.size(), picture.levels(),
                           mask.view.size(), mask.levels(), textures.back().opaque()});
    }
    std::vector<MeshTile>& kept = plan.tiles[std::size_t(tile.x)];
    if (kept.size() <= n) kept.resize(n + 1);
    if (kept[n].shows(plan.cast)) {
      kept[n].draw(textures, kernels_, rows, tile);
      return first;
    }
    // What stays is kept from the second frame on. What moves in every frame is not: that would be written to
    // memory for nothing.
    MeshTile& cast = kept[n].expects(plan.cast) ? kept[n] : plan.moving;
    plan.caster.cast(plan.cast, lens_.pieces(tile.x, tile.y), area(), kernels_, {tile.x, tile.y, tile.rect},
                     cast);
    cast.draw(textures, kernels_, rows, tile);
    return first;
  }
  std::size_t cast(const TileCast& tile_cast, Plan& plan, Tile<Light>& tile) const {
    return draw_cast(tile_cast, plan.lights, plan.light_rows, plan, tile);
  }
  std::size_t cast(const TileCast& tile_cast, Plan& plan, Tile<Value>& tile) const {
    return draw_cast(tile_cast, plan.values, plan.value_rows, plan, tile);
  }

  /// Asks for the memory that will be written when the tile is drawn.
  template <typename Number>
  static void fetch_ahead(const PixelRect& rect, ImageView<Number> frame) {
    constexpr int kLine = 64 / int(sizeof(Number));  // of memory
    for (int y = rect.y0; y < rect.y1; ++y) {
      const Number* const row = frame.row(y);
      for (int i = rect.x0 * 3; i < rect.x1 * 3; i += kLine) __builtin_prefetch(row + i, 1);
    }
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
    // Each time as much as there is already.
    Pixel* const pixels = tile.pixels.data();
    std::copy_n(colour, 4, pixels);
    for (std::size_t n = 4; n < tile.pixels.size(); n *= 2)
      std::copy_n(pixels, std::min(n, tile.pixels.size() - n), pixels + n);
  }

  RenderOptions options_;
  const Kernels& kernels_;
  LightCurve curve_;
  Workers workers_;
  LensMap lens_;
  std::vector<Item> items_;
  std::vector<Layer> layers_;
  std::vector<Plan> plans_;
  std::vector<std::uint8_t> alpha_;  ///< of a mask, while it is prepared
};

CpuRenderer::CpuRenderer(const RenderOptions& options) : state_(std::make_unique<State>(options)) {}
CpuRenderer::CpuRenderer(CpuRenderer&&) noexcept = default;
CpuRenderer& CpuRenderer::operator=(CpuRenderer&&) noexcept = default;
CpuRenderer::~CpuRenderer() = default;

RenderWork CpuRenderer::render(const Scene& scene, const Projector& projector,
                               ImageView<std::uint8_t> frame) {
  return state_->render(scene, projector, frame);
}
RenderWork CpuRenderer::render(const Scene& scene, const Projector& projector, ImageView<float> frame) {
  return state_->render(scene, projector, frame);
}

void render(const Scene& scene, const Projector& projector, ImageView<std::uint8_t> frame,
            const RenderOptions& options) {
  CpuRenderer(options).render(scene, projector, frame);
}

ImageU8 render(const Scene& scene, const Projector& projector, const RenderOptions& options) {
  require_drawable(projector.size());
  ImageU8 frame(projector.size(), 3);
  render(scene, projector, frame.view(), options);
  return frame;
}

}  // namespace procam::render
