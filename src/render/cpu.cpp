#include "procam/render/cpu.hpp"

#include <Eigen/LU>
#include <cstring>

#include "plane_layer.hpp"
#include "room_tile.hpp"

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
  /// What is drawn on a tile, one after the other: a plane, or surfaces of the room that hide each other.
  struct Step {
    std::size_t first_item = 0, count = 0;  ///< in Scratch::items
    bool cast = false;
  };
  /// Kept by each band of tiles.
  struct Scratch {
    std::vector<std::size_t> items;
    std::vector<Step> steps;
    std::vector<RoomItem<LightTexture>> light;
    std::vector<RoomItem<ValueTexture>> values;
    std::unique_ptr<RoomTile> room;
  };
  struct Item {
    ViewU8 picture;
    std::uint64_t revision = 0;
    LightTexture light;  ///< this or the other, see values_only()
    ValueTexture values;
    PlaneLayer layer;  ///< of planes and pixel surfaces
    RoomLayer room;    ///< of planes and meshes
    bool in_room = false, is_mesh = false;

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

  bool area() const { return options_.filter == Filter::kArea; }

  RenderWork prepare(const Scene& scene, const Projector& projector) {
    const bool same_lens = !lens_.update(projector, workers_);
    items_.resize(scene.items.size());
    scratch_.resize(std::size_t(lens_.grid().down()));
    RenderWork work;
    for (std::size_t i = 0; i < items_.size(); ++i) {
      const SceneItem& shown = scene.items[i];
      Item& item = items_[i];
      const auto* mesh = std::get_if<PlacedMesh>(&shown.placement);
      const auto* plane = std::get_if<PlacedPlane>(&shown.placement);
      item.in_room = mesh || plane;
      item.is_mesh = mesh != nullptr;
      bool made = mesh ? item.room.update(*mesh, projector, same_lens)
                       : item.layer.update(view_of(shown), lens_, same_lens, area(), workers_);
      if (plane) made |= item.room.update(*plane, projector, same_lens);
      work.maps += made;
      // How far a mesh's content is minified is not known before it is drawn.
      const int levels = !mesh ? item.layer.levels() : area() ? levels_of(shown.content.size()) : 1;
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
  void draw_band(int y, const Scene& scene, ImageView<std::uint8_t> frame) {
    using Pixel = typename Texture::Pixel;
    Tile<Pixel> tile;
    tile.y = y;
    Scratch& scratch = scratch_[std::size_t(y)];
    for (tile.x = 0; tile.x < lens_.grid().across(); ++tile.x) {
      tile.rect = lens_.grid().tile(tile.x, y);
      fetch_ahead(tile.rect, frame);
      plan(tile.x, y, scratch);
      // From the last that hides all before it.
      std::size_t first = scratch.steps.size();
      while (first > 0 && !hides<Texture>(scratch, scratch.steps[first - 1], tile.x, y)) --first;
      if (first == 0)
        fill(scene.background, tile);
      else
        --first;
      for (std::size_t i = first; i < scratch.steps.size(); ++i)
        draw_step<Texture>(scratch, scratch.steps[i], tile);
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

  /// The steps for a tile, back to front. Surfaces in the room hide each other by distance; pixel surfaces
  /// stay in the scene's order.
  void plan(int tile_x, int tile_y, Scratch& scratch) const {
    scratch.items.clear();
    scratch.steps.clear();
    std::size_t run = 0;  // where the surfaces in the room begin that no pixel surface parts
    const auto end_run = [&] {
      const std::size_t count = scratch.items.size() - run;
      if (count == 0) return;
      if (order(tile_x, tile_y, &scratch.items[run], count))
        for (std::size_t i = 0; i < count; ++i) scratch.steps.push_back({run + i, 1, false});
      else
        scratch.steps.push_back({run, count, true});
      run += count;
    };
    for (std::size_t i = 0; i < items_.size(); ++i) {
      const Item& item = items_[i];
      if (item.is_mesh ? item.room.boxes(tile_x, tile_y).empty() : !item.layer.touches(tile_x, tile_y))
        continue;
      if (!item.in_room) end_run();
      scratch.items.push_back(i);
      if (item.in_room) continue;
      scratch.steps.push_back({run, 1, false});
      ++run;
    }
    end_run();
  }

  /// Sorts surfaces of the room back to front if that is one order all over the tile.
  bool order(int tile_x, int tile_y, std::size_t* items, std::size_t count) const {
    for (std::size_t i = 0; i < count; ++i)
      if (items_[items[i]].is_mesh) return false;
    // A handful. Nothing is moved before all pairs are known to have an order.
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (!is_hidden(items[i], items[j], tile_x, tile_y)) return false;
    for (std::size_t i = 1; i < count; ++i)
      for (std::size_t j = i; j > 0 && *is_hidden(items[j], items[j - 1], tile_x, tile_y); --j)
        std::swap(items[j], items[j - 1]);
    return true;
  }

  /// Does plane a lie behind plane b all over the tile? Where they lie together the earlier is behind.
  /// nullopt: here a is, there b.
  std::optional<bool> is_hidden(std::size_t a, std::size_t b, int tile_x, int tile_y) const {
    const auto nearness = [&](std::size_t i) {
      const float(&n)[3] = items_[i].room.facets()[0].nearness;
      return Eigen::RowVector3d(double(n[0]), double(n[1]), double(n[2]));
    };
    const std::size_t later = std::max(a, b), earlier = std::min(a, b);
    const Eigen::RowVector3d ahead = (1 - double(kTogether)) * nearness(earlier) - nearness(later);
    bool earlier_somewhere = false, later_somewhere = false;
    for (const LensPiece& piece : lens_.pieces(tile_x, tile_y)) {
      const Patch::Bounds bounds = piece.direction_from_pixel.bounds(ahead);
      earlier_somewhere |= bounds.high > 0;
      later_somewhere |= bounds.low <= 0;
    }
    if (earlier_somewhere && later_somewhere) return std::nullopt;
    return (earlier_somewhere ? later : earlier) == a;
  }

  template <typename Texture>
  void draw_step(Scratch& scratch, const Step& step, Tile<typename Texture::Pixel>& tile) const {
    if (!step.cast) {
      const Item& item = items_[scratch.items[step.first_item]];
      item.layer.draw(item.template texture<Texture>(), kernels_, tile);
      return;
    }
    auto& items = [&]() -> auto& {
      if constexpr (std::is_same_v<Texture, LightTexture>)
        return scratch.light;
      else
        return scratch.values;
    }
    ();
    items.clear();
    for (std::size_t i = 0; i < step.count; ++i) {
      const Item& item = items_[scratch.items[step.first_item + i]];
      items.push_back({&item.room, &item.template texture<Texture>()});
    }
    if (!scratch.room) scratch.room = std::make_unique<RoomTile>();
    scratch.room->draw(items, lens_.pieces(tile.x, tile.y), area(), kernels_, tile);
  }

  template <typename Texture>
  bool hides(const Scratch& scratch, const Step& step, int tile_x, int tile_y) const {
    const Item& item = items_[scratch.items[step.first_item]];
    return !step.cast && item.template texture<Texture>().opaque() && item.layer.covers(tile_x, tile_y);
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
  std::vector<Scratch> scratch_;
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
