#include "procam/render/cpu.hpp"

#include <Eigen/LU>

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
    ahead[k] = (1 - double(kTogether)) * double(a.nearness[k]) - double(b.nearness[k]);
  bool somewhere = false, not_somewhere = false;
  for (const LensPiece& piece : pieces) {
    const Patch::Bounds bounds = piece.direction_from_pixel.bounds(ahead);
    somewhere = somewhere || bounds.high > 0;
    not_somewhere = not_somewhere || bounds.low <= 0;
  }
  if (somewhere && not_somewhere) return std::nullopt;
  return somewhere;
}

void require_drawable(const Scene& scene, const Projector& projector, ImageView<std::uint8_t> frame) {
  if (!(frame.channels == 3 && frame.size() == projector.size() && !frame.empty()))
    throw std::invalid_argument("render: the frame must have 3 channels and the projector's size");
  for (const SceneItem& item : scene.items) {
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

void to_frame(const Kernels& kernels, const LightCurve&, const Value* from, int count, std::uint8_t* to) {
  kernels.values_to_rgb(from, count, to);
}
void to_frame(const Kernels&, const LightCurve& curve, const Light* from, int count, std::uint8_t* to) {
  for (int i = 0; i < count; ++i, from += 4)
    for (int k = 0; k < 3; ++k) *to++ = curve.value(from[k]);
}

}  // namespace

/// A tile of the frame at a time is filled from back to front. Planes in the room are put in the order of
/// their depth; where that changes within a tile, and where there are meshes, each pixel is cast at
/// (room_tile.hpp). Pixel surfaces lie where the scene has them, and part what is in the room before them
/// from what comes after.
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
  };
  struct Item {
    Shown picture, mask;
    PlacedMesh mesh;                ///< of a mesh: its pose and triangles as they were
    PlaneLayer layer;               ///< of a plane or a pixel surface
    std::optional<RoomLayer> room;  ///< of a plane or a mesh

    bool is_mesh() const { return room && !room->is_plane(); }
    bool touches(int x, int y) const { return is_mesh() ? !room->boxes(x, y).empty() : layer.touches(x, y); }
    template <typename Texture>
    const Texture& texture() const {
      return picture.texture<Texture>();
    }
    template <typename Texture>
    const Texture* mask_texture() const {
      return mask.view.empty() ? nullptr : &mask.texture<Texture>();
    }
    template <typename Texture>
    bool opaque() const {
      return texture<Texture>().opaque() && mask.view.empty();
    }
  };

  /// What is worked out for a tile; one a band, kept from frame to frame.
  struct Plan {
    std::vector<const Item*> steps;  ///< back to front; nullptr: cast at what comes before the next nullptr
    std::vector<const Item*> group;  ///< in the room, between two pixel surfaces
    std::vector<std::int8_t> order;  ///< [later, earlier]: the later one is drawn first
    std::vector<RoomItem<LightTexture>> cast_light;
    std::vector<RoomItem<ValueTexture>> cast_values;
    std::unique_ptr<RoomTile> room;

    template <typename Texture>
    std::vector<RoomItem<Texture>>& cast() {
      if constexpr (std::is_same_v<Texture, LightTexture>)
        return cast_light;
      else
        return cast_values;
    }
  };

  bool area() const { return options_.filter == Filter::kArea; }
  /// Plain interpolation of values needs no more than 8 bits.
  bool values_only() const { return !area() && !options_.linear_light; }

  RenderWork prepare(const Scene& scene, const Projector& projector) {
    const bool same_lens = !lens_.update(projector, workers_);
    plans_.resize(std::size_t(lens_.grid().down()));
    items_.resize(scene.items.size());
    RenderWork work;
    for (std::size_t i = 0; i < items_.size(); ++i) {
      const SceneItem& shown = scene.items[i];
      Item& item = items_[i];
      work.maps += place(shown, projector, same_lens, item);
      work.contents += prepare(
          shown.content, shown.content_revision,
          item.is_mesh() ? levels_of(shown.content.size()) : item.layer.levels(),
          [](ViewU8 view) { return view; }, item.picture);
      if (!shown.mask.empty())
        work.contents += prepare(
            shown.mask, shown.mask_revision,
            item.is_mesh() ? levels_of(shown.mask.size()) : item.layer.mask_levels(),
            [&](ViewU8 view) { return as_alpha(view); }, item.mask);
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
      ready.values.prepare(convert(view), workers_);
    else
      ready.light.prepare(convert(view), curve_, levels, workers_);
    return true;
  }
  /// A mask as the alpha of black; in memory that is used again.
  ViewU8 as_alpha(ViewU8 mask) {
    const std::size_t pixels = std::size_t(mask.width) * std::size_t(mask.height);
    alpha_.assign(4 * pixels, 0);
    std::uint8_t* to = alpha_.data() + 3;
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x, to += 4) *to = mask.at(x, y);
    return {alpha_.data(), mask.width, mask.height, 4};
  }

  /// Returns whether anything had to be made.
  bool place(const SceneItem& shown, const Projector& projector, bool same_lens, Item& item) {
    if (const auto* mesh = std::get_if<PlacedMesh>(&shown.placement)) {
      const Pose &a = mesh->projector_from_surface, &b = item.mesh.projector_from_surface;
      if (same_lens && item.is_mesh() && mesh->mesh == item.mesh.mesh && a.translation == b.translation &&
          a.rotation.coeffs() == b.rotation.coeffs())
        return false;
      item.mesh = *mesh;
      item.room.emplace(*mesh, projector, lens_.grid());
      return true;
    }
    const auto* plane = std::get_if<PlacedPlane>(&shown.placement);
    const PlaneView view =
        plane ? view_of(*plane, shown) : view_of(std::get<PlacedPixels>(shown.placement), shown);
    const bool made = item.layer.update(view, lens_, same_lens, area(), workers_);
    if (!plane)
      item.room.reset();
    else if (made || !item.room || item.is_mesh())
      item.room.emplace(*plane, lens_.grid());
    return made;
  }

  template <typename Texture>
  void draw_band(int y, const Scene& scene, ImageView<std::uint8_t> frame) {
    Plan& plan = plans_[std::size_t(y)];
    Tile<typename Texture::Pixel> tile;
    tile.y = y;
    for (tile.x = 0; tile.x < lens_.grid().across(); ++tile.x) {
      tile.rect = lens_.grid().tile(tile.x, y);
      fetch_ahead(tile.rect, frame);
      find_steps(tile.x, y, plan);
      std::size_t first = 0;
      if (!find_first<Texture>(plan, tile.x, y, first)) fill(scene.background, tile);
      for (std::size_t i = first; i < plan.steps.size(); ++i) {
        if (plan.steps[i])
          plan.steps[i]->layer.draw(plan.steps[i]->template texture<Texture>(),
                                    plan.steps[i]->template mask_texture<Texture>(), kernels_, tile);
        else
          i = cast(plan, i + 1, tile);
      }
      for (int row = 0; row < tile.rect.height(); ++row)
        to_frame(kernels_, curve_, tile.row(row), tile.rect.width(),
                 frame.row(tile.rect.y0 + row) + std::ptrdiff_t(tile.rect.x0) * 3);
    }
  }

  /// The topmost step that hides all below it; false when there is none.
  template <typename Texture>
  static bool find_first(const Plan& plan, int x, int y, std::size_t& first) {
    bool in_cast = false;
    for (std::size_t i = plan.steps.size(); i-- > 0;) {
      const Item* const step = plan.steps[i];
      if (!step) {
        in_cast = !in_cast;
      } else if (!in_cast && step->opaque<Texture>() && step->layer.covers(x, y)) {
        first = i;
        return true;
      }
    }
    return false;
  }

  void find_steps(int x, int y, Plan& plan) const {
    plan.steps.clear();
    plan.group.clear();
    for (const Item& item : items_) {
      if (!item.touches(x, y)) continue;
      if (item.room) {
        plan.group.push_back(&item);
        continue;
      }
      add_group(x, y, plan);
      plan.steps.push_back(&item);
    }
    add_group(x, y, plan);
  }

  /// The group's steps: its planes by depth, or a cast. Empties it.
  void add_group(int x, int y, Plan& plan) const {
    std::vector<const Item*>& group = plan.group;
    const std::size_t count = group.size();
    const auto is_mesh = [](const Item* item) { return item->is_mesh(); };
    bool ordered = std::none_of(group.begin(), group.end(), is_mesh) && find_order(x, y, plan);
    const auto must_wait = [&](std::size_t i) {
      for (std::size_t j = 0; j < count; ++j)
        if (group[j] && j != i && plan.order[std::max(i, j) * count + std::min(i, j)] == (j > i ? 1 : -1))
          return true;
      return false;
    };
    for (std::size_t left = count; ordered && left > 0; --left) {
      // The first in the scene's order that nothing left must come before. There is none where planes lie
      // over each other in a ring.
      std::size_t next = 0;
      while (next < count && (!group[next] || must_wait(next))) ++next;
      ordered = next < count;
      if (!ordered) break;
      plan.steps.push_back(group[next]);
      group[next] = nullptr;
    }
    if (!ordered) {
      plan.steps.push_back(nullptr);
      for (const Item* const item : group)
        if (item) plan.steps.push_back(item);
      plan.steps.push_back(nullptr);
    }
    group.clear();
  }

  /// Which of each two overlapping planes is drawn first; false where that is not the same all over the tile.
  bool find_order(int x, int y, Plan& plan) const {
    const std::size_t count = plan.group.size();
    plan.order.assign(count * count, 0);
    for (std::size_t later = 1; later < count; ++later)
      for (std::size_t earlier = 0; earlier < later; ++earlier) {
        const Item &a = *plan.group[earlier], &b = *plan.group[later];
        if (!a.layer.overlaps(b.layer, x, y)) continue;
        const auto hidden = hides(a.room->facets()[0], b.room->facets()[0], lens_.pieces(x, y));
        if (!hidden) return false;
        plan.order[later * count + earlier] = *hidden ? 1 : -1;
      }
    return true;
  }

  /// Casts at the steps from `first` up to the next nullptr, whose place is returned.
  template <typename Pixel>
  std::size_t cast(Plan& plan, std::size_t first, Tile<Pixel>& tile) const {
    using Texture = std::conditional_t<std::is_same_v<Pixel, Light>, LightTexture, ValueTexture>;
    std::vector<RoomItem<Texture>>& items = plan.template cast<Texture>();
    items.clear();
    for (; plan.steps[first]; ++first)
      items.push_back({&*plan.steps[first]->room, &plan.steps[first]->template texture<Texture>(),
                       plan.steps[first]->template mask_texture<Texture>()});
    if (!plan.room) plan.room = std::make_unique<RoomTile>();
    plan.room->draw(items, lens_.pieces(tile.x, tile.y), area(), kernels_, tile);
    return first;
  }

  /// Asks for the memory that will be written when the tile is drawn.
  static void fetch_ahead(const PixelRect& rect, ImageView<std::uint8_t> frame) {
    constexpr int kLine = 64;  // bytes
    for (int y = rect.y0; y < rect.y1; ++y) {
      const std::uint8_t* const row = frame.row(y);
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
    for (std::size_t i = 0; i < tile.pixels.size(); i += 4) std::copy_n(colour, 4, &tile.pixels[i]);
  }

  RenderOptions options_;
  const Kernels& kernels_;
  LightCurve curve_;
  Workers workers_;
  LensMap lens_;
  std::vector<Item> items_;
  std::vector<Plan> plans_;
  std::vector<std::uint8_t> alpha_;
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
