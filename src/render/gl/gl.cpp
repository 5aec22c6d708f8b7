#include "procam/render/gl.hpp"

#include <epoxy/gl.h>

#include "kept_state.hpp"
#include "state.hpp"

namespace procam::render_gl {

using render::LensPiece;
using render::RenderOptions;
using render::RenderWork;

GlRenderer::State::State(const RenderOptions& options, Context context)
    : options_(options), curve_(options.linear_light), workers_(options.threads) {
  if (context == Context::kOwn)
    own_ = std::make_unique<OwnContext>();
  else
    require_current_context();
  const auto use = used();
  const KeptState kept;
  const auto words = [](GLenum name) {
    const auto* const text = reinterpret_cast<const char*>(glGetString(name));
    return std::string(text ? text : "?");
  };
  device_ = words(GL_RENDERER) + ", " + words(GL_VERSION);
  GLint largest = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  while (row_bits_ < 13 && (2 << row_bits_) <= largest) ++row_bits_;
  max_rows_ = largest;
  on_card_ = std::make_unique<OnCard>();
  write_values();
}

GlRenderer::State::~State() {
  try {
    const auto use = used();
    on_card_.reset();
  } catch (const Error&) {  // the context is lost, and with it what it held
  }
}

RenderWork GlRenderer::State::render(const Scene& scene, const Projector& projector,
                                     ImageView<std::uint8_t> frame) {
  if (!(frame.channels == 3 && frame.size() == projector.size() && !frame.empty()))
    throw std::invalid_argument("render: the frame must have 3 channels and the projector's size");
  render::require_drawable(scene, projector.size());
  const auto use = used();
  const KeptState kept;
  const RenderWork work = prepare(scene, projector);
  draw(scene);
  read(frame);
  return work;
}

RenderWork GlRenderer::State::draw_current(const Scene& scene, const Projector& projector, int rows) {
  if (own_) throw std::invalid_argument("draw: the renderer has a context of its own; make it with kCurrent");
  if (!(rows >= projector.size().height))
    throw std::invalid_argument("draw: the framebuffer has " + std::to_string(rows) +
                                " rows, less than the projector's frame");
  render::require_drawable(scene, projector.size());
  const KeptState kept;
  const RenderWork work = prepare(scene, projector);
  draw(scene);
  copy(kept.framebuffer(), rows);
  check("drawing");
  return work;
}

void GlRenderer::State::check(const char* what) {
  const GLenum fault = glGetError();
  if (fault == GL_NO_ERROR) return;
  while (glGetError() != GL_NO_ERROR) {
  }
  refuse("OpenGL", fault == GL_OUT_OF_MEMORY ? std::string("the card is out of memory (") + what + ")"
                                             : "error " + std::to_string(fault) + " (" + what + ")");
}

void GlRenderer::State::write_values() {
  std::vector<std::uint8_t> values;
  for (int light = 0; light <= render::kFull; light += 4)
    values.push_back(curve_.value(render::Light(light)));
  on_card_->values.reserve(values.size(), row_bits_, max_rows_);
  on_card_->values.write(0, values.size(), values.data());
}

template <typename Convert>
bool GlRenderer::State::prepare(ViewU8 view, std::uint64_t revision, int levels, const Convert& convert,
                                Shown& ready) {
  const ImageSize size = ready.view.size();
  const int were = ready.levels();
  ready.is_new = !view.empty() && !(render::same_view(view, ready.view) && revision == ready.revision &&
                                    levels <= ready.light.levels());
  ready.view = view;
  ready.revision = revision;
  if (ready.is_new) ready.light.prepare(convert(view), curve_, levels, workers_);
  return size != view.size() || were != ready.levels();
}

RenderWork GlRenderer::State::prepare(const Scene& scene, const Projector& projector) {
  const bool new_lens = lens_.update(projector, workers_);
  projector_ = &projector;
  bool new_lists = new_lens || items_.size() != scene.items.size();
  items_.resize(scene.items.size());
  layers_.resize(scene.items.size());
  RenderWork work;
  for (std::size_t i = 0; i < items_.size(); ++i) {
    const SceneItem& shown = scene.items[i];
    Item& item = items_[i];
    item.new_map = layers_[i].place(shown, projector, lens_, !new_lens, area(), workers_);
    work.maps += item.new_map;
    const bool was_opaque = item.opaque();
    const bool new_picture = prepare(
        shown.content, shown.content_revision, layers_[i].levels(shown.content.size()),
        [](ViewU8 view) { return view; }, item.picture);
    const bool new_mask = prepare(
        shown.mask, shown.mask_revision, layers_[i].mask_levels(shown.mask.size()),
        [&](ViewU8 view) { return render::as_alpha(view, alpha_); }, item.mask);
    work.contents += item.picture.is_new + item.mask.is_new;
    new_lists = new_lists || item.new_map || new_picture || new_mask || was_opaque != item.opaque();
  }
  if (new_lens) write_rays();
  if (new_lists) {
    write_numbers();
    write_lists();
  }
  write_contents();
  if (new_lists) cast(new_lens);
  check("sending what is new");
  return work;
}

void GlRenderer::State::write_rays() {
  has_lens_ = !std::holds_alternative<NoDistortion>(projector_->inverse_camera.distortion);
  const ImageSize frame = lens_.grid().frame;
  on_card_->rays.resize(has_lens_ ? frame.width + 2 : 1, has_lens_ ? frame.height + 2 : 1);
  if (!has_lens_) return;
  const int across = frame.width + 2;
  std::vector<Float4> rays(std::size_t(across) * std::size_t(frame.height + 2), Float4{0, 0, 0, 0});
  workers_.run(lens_.grid().down(), [&](int tile_y) {
    for (int tile_x = 0; tile_x < lens_.grid().across(); ++tile_x)
      for (const LensPiece& piece : lens_.pieces(tile_x, tile_y)) {
        const render::PixelRect& r = piece.rect;
        for (int y = r.y0 - (r.y0 == 0); y < r.y1 + (r.y1 == frame.height); ++y)
          for (int x = r.x0 - (r.x0 == 0); x < r.x1 + (r.x1 == frame.width); ++x) {
            const Vec3 d = piece.direction_from_pixel.at(r.s(x), r.t(y));
            rays[std::size_t(y + 1) * std::size_t(across) + std::size_t(x + 1)] = {float(d.x()), float(d.y()),
                                                                                   float(d.z()), 1};
          }
      }
  });
  on_card_->rays.write(0, 0, across, frame.height + 2, rays.data());
}

void GlRenderer::State::write_contents() {
  const bool lost = on_card_->content.reserve(content_texels_, row_bits_, max_rows_);
  for (const Item& item : items_)
    for (const Shown* const shown : item.records()) {
      if (!shown->is_new && !moved_contents_ && !lost) continue;
      for (int l = 0; l < shown->levels(); ++l) {
        const auto level = shown->light.level(l);
        on_card_->content.write(shown->first_texel[std::size_t(l)],
                                std::size_t(level.stride) * std::size_t(level.height + 1), level.data);
      }
    }
  moved_contents_ = false;
}

GlRenderer::GlRenderer(const RenderOptions& options, Context context)
    : state_(std::make_unique<State>(options, context)) {}
GlRenderer::GlRenderer(GlRenderer&&) noexcept = default;
GlRenderer& GlRenderer::operator=(GlRenderer&&) noexcept = default;
GlRenderer::~GlRenderer() = default;

RenderWork GlRenderer::render(const Scene& scene, const Projector& projector, ImageView<std::uint8_t> frame) {
  return state_->render(scene, projector, frame);
}
RenderWork GlRenderer::draw(const Scene& scene, const Projector& projector, int rows) {
  return state_->draw_current(scene, projector, rows);
}
std::string GlRenderer::device() const {
  return state_->device();
}

}  // namespace procam::render_gl
