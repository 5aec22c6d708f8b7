#include "procam/render_gl/gl.hpp"

#include <epoxy/gl.h>

#include <array>
#include <cstring>
#include <vector>

#include "context.hpp"
#include "objects.hpp"
#include "render/kernels.hpp"
#include "render/layers.hpp"
#include "render/light.hpp"
#include "render/room_tile.hpp"
#include "shaders.hpp"

namespace procam::render_gl {

namespace {

using render::FacetBox;
using render::Layer;
using render::LensPiece;
using render::RenderOptions;
using render::RenderWork;
using render::Taps;
using render::TileSteps;

using Int4 = std::array<std::int32_t, 4>;
using Float4 = std::array<float, 4>;

constexpr int kOpaque = 1, kMesh = 2, kNotThroughLens = 4, kMasked = 8;  // as kCommon reads them

std::int32_t bits(float value) {
  std::int32_t result = 0;
  std::memcpy(&result, &value, sizeof result);
  return result;
}
Int4 packed(const Taps& taps) {
  return {taps.level, taps.across | taps.down << 16, bits(taps.share_across), bits(taps.share_down)};
}

Program linked(const char* vertices, const std::string& fragments) {
  const std::string version = epoxy_is_desktop_gl() ? "#version 330 core\n" : "#version 300 es\n";
  const std::string head = version +
                           "precision highp float;\nprecision highp int;\n"
                           "const int kFacetTexels = " +
                           std::to_string(kFacetTexels) +
                           ", kRecordTexels = " + std::to_string(kRecordTexels) +
                           ", kMostGroups = " + std::to_string(kMostGroups) + ";\n";
  Program program(glCreateProgram());
  std::array<Shader, 2> shaders{Shader(glCreateShader(GL_VERTEX_SHADER)),
                                Shader(glCreateShader(GL_FRAGMENT_SHADER))};
  const std::string texts[2] = {head + vertices, head + fragments};
  for (std::size_t i = 0; i < 2; ++i) {
    const char* const text = texts[i].c_str();
    glShaderSource(shaders[i].name(), 1, &text, nullptr);
    glCompileShader(shaders[i].name());
    GLint done = 0;
    glGetShaderiv(shaders[i].name(), GL_COMPILE_STATUS, &done);
    if (!done) {
      char words[2000] = "";
      glGetShaderInfoLog(shaders[i].name(), sizeof words, nullptr, words);
      refuse("OpenGL", std::string("the driver does not compile a program: ") + words);
    }
    glAttachShader(program.name(), shaders[i].name());
  }
  glLinkProgram(program.name());
  GLint done = 0;
  glGetProgramiv(program.name(), GL_LINK_STATUS, &done);
  if (!done) {
    char words[2000] = "";
    glGetProgramInfoLog(program.name(), sizeof words, nullptr, words);
    refuse("OpenGL", std::string("the driver does not link a program: ") + words);
  }
  return program;
}

/// The state that the renderer changes, put back in the end.
class KeptState {
 public:
  KeptState() {
    glGetIntegerv(GL_CURRENT_PROGRAM, &program_);
    glGetIntegerv(GL_VERTEX_ARRAY_BINDING, &vertices_);
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &draw_);
    glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &read_);
    glGetIntegerv(GL_VIEWPORT, viewport_);
    glGetBooleanv(GL_DEPTH_WRITEMASK, &depth_mask_);
    for (std::size_t i = 0; i < kStencil.size(); ++i) glGetIntegerv(kStencil[i], &stencil_[i]);
    glGetIntegerv(GL_DEPTH_FUNC, &depth_function_);
    glGetBooleanv(GL_COLOR_WRITEMASK, colour_mask_);
    glGetFloatv(GL_DEPTH_CLEAR_VALUE, &depth_clear_);
    glGetFloatv(GL_DEPTH_RANGE, depth_range_);
    glGetIntegerv(GL_ACTIVE_TEXTURE, &active_);
    for (int unit = 0; unit < kUnits; ++unit) {
      glActiveTexture(GLenum(GL_TEXTURE0 + unit));
      glGetIntegerv(GL_TEXTURE_BINDING_2D, &flat_[unit]);
      glGetIntegerv(GL_TEXTURE_BINDING_2D_ARRAY, &layered_[unit]);
      glGetIntegerv(GL_SAMPLER_BINDING, &sampler_[unit]);
    }
    glGetIntegerv(GL_PIXEL_UNPACK_BUFFER_BINDING, &unpack_buffer_);
    glGetIntegerv(GL_PIXEL_PACK_BUFFER_BINDING, &pack_buffer_);
    for (std::size_t i = 0; i < kStores.size(); ++i) glGetIntegerv(kStores[i], &stores_[i]);
    for (std::size_t i = 0; i < kSwitches.size(); ++i) on_[i] = has(i) && glIsEnabled(kSwitches[i]);

    for (std::size_t i = 0; i < kSwitches.size(); ++i)
      if (has(i)) glDisable(kSwitches[i]);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthMask(GL_TRUE);
    glStencilMask(0xff);
    glDepthRangef(0, 1);
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    for (const GLenum store : kStores)
      glPixelStorei(store, store == GL_UNPACK_ALIGNMENT || store == GL_PACK_ALIGNMENT ? 1 : 0);
    for (int unit = 0; unit < kUnits; ++unit) glBindSampler(GLuint(unit), 0);
  }
  ~KeptState() {
    glUseProgram(GLuint(program_));
    glBindVertexArray(GLuint(vertices_));
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, GLuint(draw_));
    glBindFramebuffer(GL_READ_FRAMEBUFFER, GLuint(read_));
    glViewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
    glDepthMask(depth_mask_);
    for (std::size_t i = 0; i < kStencil.size(); i += 7) {
      const GLenum face = i == 0 ? GL_FRONT : GL_BACK;
      const auto* const kept = &stencil_[i];
      glStencilFuncSeparate(face, GLenum(kept[0]), kept[1], GLuint(kept[2]));
      glStencilOpSeparate(face, GLenum(kept[3]), GLenum(kept[4]), GLenum(kept[5]));
      glStencilMaskSeparate(face, GLuint(kept[6]));
    }
    glDepthFunc(GLenum(depth_function_));
    glColorMask(colour_mask_[0], colour_mask_[1], colour_mask_[2], colour_mask_[3]);
    glClearDepthf(depth_clear_);
    glDepthRangef(depth_range_[0], depth_range_[1]);
    for (int unit = 0; unit < kUnits; ++unit) {
      glActiveTexture(GLenum(GL_TEXTURE0 + unit));
      glBindTexture(GL_TEXTURE_2D, GLuint(flat_[unit]));
      glBindTexture(GL_TEXTURE_2D_ARRAY, GLuint(layered_[unit]));
      glBindSampler(GLuint(unit), GLuint(sampler_[unit]));
    }
    glActiveTexture(GLenum(active_));
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, GLuint(unpack_buffer_));
    glBindBuffer(GL_PIXEL_PACK_BUFFER, GLuint(pack_buffer_));
    for (std::size_t i = 0; i < kStores.size(); ++i) glPixelStorei(kStores[i], stores_[i]);
    for (std::size_t i = 0; i < kSwitches.size(); ++i)
      if (on_[i]) glEnable(kSwitches[i]);
  }
  KeptState(const KeptState&) = delete;
  KeptState& operator=(const KeptState&) = delete;

  GLuint framebuffer() const { return GLuint(draw_); }

 private:
  static constexpr int kUnits = 8;
  static constexpr std::array<GLenum, 10> kStores{
      GL_UNPACK_ALIGNMENT,    GL_UNPACK_ROW_LENGTH,  GL_UNPACK_SKIP_ROWS, GL_UNPACK_SKIP_PIXELS,
      GL_UNPACK_IMAGE_HEIGHT, GL_UNPACK_SKIP_IMAGES, GL_PACK_ALIGNMENT,   GL_PACK_ROW_LENGTH,
      GL_PACK_SKIP_ROWS,      GL_PACK_SKIP_PIXELS};
  /// Of front faces, and of back faces.
  static constexpr std::array<GLenum, 14> kStencil{GL_STENCIL_FUNC,
                                                   GL_STENCIL_REF,
                                                   GL_STENCIL_VALUE_MASK,
                                                   GL_STENCIL_FAIL,
                                                   GL_STENCIL_PASS_DEPTH_FAIL,
                                                   GL_STENCIL_PASS_DEPTH_PASS,
                                                   GL_STENCIL_WRITEMASK,
                                                   GL_STENCIL_BACK_FUNC,
                                                   GL_STENCIL_BACK_REF,
                                                   GL_STENCIL_BACK_VALUE_MASK,
                                                   GL_STENCIL_BACK_FAIL,
                                                   GL_STENCIL_BACK_PASS_DEPTH_FAIL,
                                                   GL_STENCIL_BACK_PASS_DEPTH_PASS,
                                                   GL_STENCIL_BACK_WRITEMASK};
  /// The last two are desktop OpenGL's.
  static constexpr std::array<GLenum, 10> kSwitches{GL_BLEND,
                                                    GL_DEPTH_TEST,
                                                    GL_CULL_FACE,
                                                    GL_SCISSOR_TEST,
                                                    GL_STENCIL_TEST,
                                                    GL_DITHER,
                                                    GL_SAMPLE_ALPHA_TO_COVERAGE,
                                                    GL_RASTERIZER_DISCARD,
                                                    GL_FRAMEBUFFER_SRGB,
                                                    GL_COLOR_LOGIC_OP};
  static bool has(std::size_t i) { return i < 8 || epoxy_is_desktop_gl(); }

  GLint program_ = 0, vertices_ = 0, draw_ = 0, read_ = 0, viewport_[4] = {}, depth_function_ = 0,
        active_ = 0, flat_[kUnits] = {}, layered_[kUnits] = {}, sampler_[kUnits] = {}, unpack_buffer_ = 0,
        pack_buffer_ = 0;
  GLboolean depth_mask_ = 0, colour_mask_[4] = {};
  GLfloat depth_clear_ = 1, depth_range_[2] = {};
  std::array<GLint, kStores.size()> stores_{};
  std::array<GLint, kStencil.size()> stencil_{};
  std::array<bool, kSwitches.size()> on_{};
};

}  // namespace

/// A frame is (1) placed: maps on the CPU, as the CPU renderer's, and sent where they are new; (2) cast,
/// where they are new: which facet a pixel meets, which pixels are edges, how blocks look; (3) drawn, by a
/// program that walks its tile's steps at each pixel.
class GlRenderer::State {
 public:
  State(const RenderOptions& options, Context context)
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
    most_rows_ = largest;
    on_card_ = std::make_unique<OnCard>();
    write_values();
  }
  ~State() {
    try {
      const auto use = used();
      on_card_.reset();
    } catch (const Error&) {  // the context is lost, and with it what it held
    }
  }

  const std::string& device() const { return device_; }

  RenderWork render(const Scene& scene, const Projector& projector, ImageView<std::uint8_t> frame) {
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

  RenderWork draw_current(const Scene& scene, const Projector& projector, int rows) {
    if (own_)
      throw std::invalid_argument("draw: the renderer has a context of its own; make it with kCurrent");
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

 private:
  /// A picture, ready to be sampled.
  struct Shown {
    ViewU8 view;
    std::uint64_t revision = 0;
    render::LightTexture light;
    std::vector<std::size_t> first_texel;  ///< of each level
    bool is_new = false;
    int layer = 0;  ///< of the taps, where it is cast at

    int levels() const { return view.empty() ? 0 : light.levels(); }
  };
  struct Item {
    Shown picture, mask;
    std::size_t first_facet = 0, facets = 0;
    bool new_map = false;
    int layer = 0;  ///< of the hits, where it is cast at

    bool opaque() const { return picture.light.opaque() && mask.view.empty(); }
    std::array<Shown*, 2> records() { return {&picture, &mask}; }
    std::array<const Shown*, 2> records() const { return {&picture, &mask}; }
  };

  /// All that lives in the context.
  struct OnCard {
    Memory lists{kInt4, kListsUnit}, numbers{kFloat4, kNumbersUnit}, content{kShort4, kContentUnit},
        values{kByte, kValuesUnit};
    Texels rays{kFloat4, kRaysUnit}, hits{kInt2, kHitsUnit}, edges{kInt, kEdgesUnit}, taps{kInt4, kTapsUnit},
        drawn{kRgba, kTapsUnit};
    Framebuffer framebuffer;
    Pixels depth{GL_DEPTH_COMPONENT32F};
    Pixels stencil{GL_DEPTH24_STENCIL8};  ///< 1 at edges
    VertexArray nothing;
    Program find_hits, find_plane_hits, find_edges, choose_taps, draw, draw_edges, copy;

    OnCard() {
      const std::string common = kCommon;
      find_hits = linked(kFacetBoxes, common + kFindHits);
      find_plane_hits = linked(kWholeFrame, common + kFindPlaneHits);
      find_edges = linked(kWholeFrame, common + kFindEdges);
      choose_taps = linked(kWholeFrame, common + kChooseTaps);
      draw = linked(kWholeFrame, common + kDraw);
      copy = linked(kWholeFrame, kCopy);
      draw_edges = linked(kWholeFrame, "#define EDGES\n" + common + kDraw);
      GLuint name = 0;
      glGenFramebuffers(1, &name);
      framebuffer = Framebuffer(name);
      glGenVertexArrays(1, &name);
      nothing = VertexArray(name);
    }
  };

  std::unique_ptr<OwnContext::Use> used() const {
    return own_ ? std::make_unique<OwnContext::Use>(*own_) : nullptr;
  }
  bool area() const { return options_.filter == render::Filter::kArea; }

  static void check(const char* what) {
    const GLenum fault = glGetError();
    if (fault == GL_NO_ERROR) return;
    while (glGetError() != GL_NO_ERROR) {
    }
    refuse("OpenGL", fault == GL_OUT_OF_MEMORY ? std::string("the card is out of memory (") + what + ")"
                                               : "error " + std::to_string(fault) + " (" + what + ")");
  }

  void write_values() {
    std::vector<std::uint8_t> values;
    for (int light = 0; light <= render::kFull; light += 4)
      values.push_back(curve_.value(render::Light(light)));
    on_card_->values.reserve(values.size(), row_bits_, most_rows_);
    on_card_->values.write(0, values.size(), values.data());
  }

  RenderWork prepare(const Scene& scene, const Projector& projector) {
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

  /// Returns whether its levels are others than before.
  template <typename Convert>
  bool prepare(ViewU8 view, std::uint64_t revision, int levels, const Convert& convert, Shown& ready) {
    const ImageSize size = ready.view.size();
    const int were = ready.levels();
    ready.is_new = !view.empty() && !(render::same_view(view, ready.view) && revision == ready.revision &&
                                      levels <= ready.light.levels());
    ready.view = view;
    ready.revision = revision;
    if (ready.is_new) ready.light.prepare(convert(view), curve_, levels, workers_);
    return size != view.size() || were != ready.levels();
  }

  /// Direction of each pixel's ray, and of those one beyond the frame; where there is a lens.
  void write_rays() {
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
              rays[std::size_t(y + 1) * std::size_t(across) + std::size_t(x + 1)] = {
                  float(d.x()), float(d.y()), float(d.z()), 1};
            }
        }
    });
    on_card_->rays.write(0, 0, across, frame.height + 2, rays.data());
  }

  static void add_numbers(const render::Facet& facet, std::vector<Float4>& to) {
    const auto& m = facet.content;
    const auto& b = facet.borders;
    for (int k = 0; k < 3; ++k) to.push_back({b[k][0], b[k][1], b[k][2], facet.nearness[k]});
    for (int k = 0; k < 3; ++k) to.push_back({m[k][0], m[k][1], m[k][2], b[3][k]});
  }

  /// Facets of all items; those of a plane or pixel surface are one.
  void write_numbers() {
    std::size_t count = 0;
    bool moved = false;
    for (std::size_t i = 0; i < items_.size(); ++i) {
      Item& item = items_[i];
      const std::size_t facets = layers_[i].is_mesh() ? layers_[i].room->facets().size() : 1;
      moved = moved || item.first_facet != count || item.facets != facets;
      item.first_facet = count;
      item.facets = facets;
      count += facets;
    }
    const bool lost = on_card_->numbers.reserve(count * kFacetTexels, row_bits_, most_rows_);
    for (std::size_t i = 0; i < items_.size(); ++i) {
      if (!items_[i].new_map && !moved && !lost) continue;
      numbers_.clear();
      const Layer& layer = layers_[i];
      if (layer.room && !layer.room->facets().empty()) {
        for (const render::Facet& facet : layer.room->facets()) add_numbers(facet, numbers_);
      } else if (!layer.is_mesh()) {
        render::Facet facet{};
        const Mat3& m = layer.plane.view().content_from_direction;
        for (int k = 0; k < 9; ++k) facet.content[k / 3][k % 3] = float(m(k / 3, k % 3));
        add_numbers(facet, numbers_);
      }
      on_card_->numbers.write(items_[i].first_facet * kFacetTexels, numbers_.size(), numbers_.data());
    }
  }

  /// One more on each side: corners of packed boxes are not below 0.
  static Int4 packed_box(const FacetBox& box, std::size_t first_facet) {
    return {(box.x0 + 1) | (box.y0 + 1) << 16, (box.x1 + 1) | (box.y1 + 1) << 16,
            std::int32_t(first_facet) + box.facet, 0};
  }

  void write_lists() {
    // Where the levels of the contents and masks lie.
    content_texels_ = 0;
    for (Item& item : items_)
      for (Shown* const shown : item.records()) {
        shown->first_texel.clear();
        for (int l = 0; l < shown->levels(); ++l) {
          const auto level = shown->light.level(l);
          shown->first_texel.push_back(content_texels_);
          const std::size_t texels = std::size_t(level.stride) * std::size_t(level.height + 1);
          const std::size_t row = std::size_t(1) << row_bits_;
          content_texels_ += (texels + row - 1) / row * row;
        }
      }
    moved_contents_ = true;

    const render::TileGrid grid = lens_.grid();
    lists_.clear();
    lists_.resize(items_.size() * 2 * kRecordTexels);
    for (std::size_t i = 0; i < items_.size(); ++i) {
      const Item& item = items_[i];
      const Layer& layer = layers_[i];
      const bool through_lens = layer.room || layer.plane.view().through_lens;
      for (std::size_t n = 0; n < 2; ++n) {
        const Shown& shown = *item.records()[n];
        Int4* const record = &lists_[(2 * i + n) * kRecordTexels];
        record[0] = {0, 0, shown.levels(), 0};
        for (int l = 0; l < shown.levels(); ++l) {
          const auto level = shown.light.level(l);
          record[1 + l] = {std::int32_t(shown.first_texel[std::size_t(l)]), level.width, level.height,
                           level.stride};
        }
      }
      Int4& head = lists_[2 * i * kRecordTexels];
      head[0] = std::int32_t(item.first_facet);
      head[1] = (item.opaque() ? kOpaque : 0) | (layer.is_mesh() ? kMesh : 0) |
                (through_lens ? 0 : kNotThroughLens) | (item.mask.view.empty() ? 0 : kMasked);
    }
    first_tile_ = lists_.size();
    lists_.resize(first_tile_ + std::size_t(grid.across()) * std::size_t(grid.down()));
    cast_at_.assign(items_.size(), false);
    for (int y = 0; y < grid.down(); ++y)
      for (int x = 0; x < grid.across(); ++x) add_tile(x, y);
    // Those cast at have a layer of the hits, and the same of the taps; the taps of masks come after all
    // these.
    layers_cast_ = 0;
    for (std::size_t i = 0; i < items_.size(); ++i)
      if (cast_at_[i])
        lists_[2 * i * kRecordTexels][3] = items_[i].layer = items_[i].picture.layer = layers_cast_++;
    tap_layers_ = layers_cast_;
    for (std::size_t i = 0; i < items_.size(); ++i)
      if (cast_at_[i] && !items_[i].mask.view.empty())
        lists_[(2 * i + 1) * kRecordTexels][3] = items_[i].mask.layer = tap_layers_++;
    first_box_.assign(items_.size(), 0);
    for (std::size_t i = 0; i < items_.size(); ++i) {
      if (!layers_[i].is_mesh()) continue;
      first_box_[i] = lists_.size();
      for (const FacetBox& box : layers_[i].room->boxes())
        lists_.push_back(packed_box(box, items_[i].first_facet));
    }
    on_card_->lists.reserve(lists_.size(), row_bits_, most_rows_);
    on_card_->lists.write(0, lists_.size(), lists_.data());
  }

  /// The steps of a tile, and what they refer to.
  void add_tile(int x, int y) {
    const std::vector<int>& steps = steps_.find(layers_, lens_, x, y);
    // What an opaque plane hides all over the tile is left out.
    std::size_t first = steps.size();
    bool in_cast = false, hidden = false;
    while (first > 0 && !hidden) {
      const int step = steps[--first];
      if (step == TileSteps::kCast)
        in_cast = !in_cast;
      else
        hidden =
            !in_cast && items_[std::size_t(step)].opaque() && layers_[std::size_t(step)].plane.covers(x, y);
    }
    const std::size_t begin = lists_.size();
    for (std::size_t i = first; i < steps.size(); ++i) {
      if (steps[i] != TileSteps::kCast) {
        const bool whole = layers_[std::size_t(steps[i])].plane.covers(x, y);
        lists_.push_back({steps[i], 0, whole, 0});
        continue;
      }
      const std::size_t head = lists_.size();
      lists_.push_back({-1, 0, 0, 0});
      for (++i; steps[i] != TileSteps::kCast; ++i) {
        lists_.push_back({steps[i], 0, 0, 0});
        ++lists_[head][1];
        cast_at_[std::size_t(steps[i])] = true;
      }
    }
    const std::size_t end = lists_.size();
    lists_[first_tile_ + std::size_t(y * lens_.grid().across() + x)] = {std::int32_t(begin),
                                                                        std::int32_t(end - begin), 0, 0};
    for (std::size_t at = begin; at < end; ++at) {
      const int cast = lists_[at][0] < 0 ? lists_[at][1] : -1;
      if (cast < 0) {
        const auto item = std::size_t(lists_[at][0]);
        lists_[at][1] = std::int32_t(lists_.size());
        for (const Taps& taps : layers_[item].plane.taps(x, y)) lists_.push_back(packed(taps));
        for (const Taps& taps : layers_[item].plane.mask_taps(x, y)) lists_.push_back(packed(taps));
        continue;
      }
      for (int n = 0; n < cast; ++n) {
        ++at;
        const auto item = std::size_t(lists_[at][0]);
        lists_[at][1] = std::int32_t(lists_.size());
        add_boxes(layers_[item].room->boxes(x, y), items_[item].first_facet, lens_.grid().tile(x, y));
      }
    }
  }

  /// For each block of a tile, the first of its boxes and their number; then these. (An edge pixel looks at
  /// all of its block's, and a tile may hold a thousand.)
  void add_boxes(const render::FacetBoxes& boxes, std::size_t first_facet, const render::PixelRect& tile) {
    constexpr int kAcross = render::kTileWidth / kBlocksAcross, kDown = render::kTileHeight / kBlocksDown;
    const std::size_t blocks = lists_.size();
    lists_.resize(blocks + kBlocksAcross * kBlocksDown, Int4{0, 0, 0, 0});
    const auto for_blocks = [&](const FacetBox& box, const auto& visit) {
      // A pixel may be touched whose middle is not.
      const int x0 = std::max(box.x0 - 1 - tile.x0, 0) / kAcross,
                y0 = std::max(box.y0 - 1 - tile.y0, 0) / kDown;
      const int x1 = std::min((box.x1 - tile.x0) / kAcross + 1, kBlocksAcross),
                y1 = std::min((box.y1 - tile.y0) / kDown + 1, kBlocksDown);
      for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) visit(blocks + std::size_t(y * kBlocksAcross + x));
    };
    for (const FacetBox& box : boxes) for_blocks(box, [&](std::size_t block) { ++lists_[block][1]; });
    std::size_t end = lists_.size();
    for (std::size_t block = blocks; block < lists_.size(); ++block) {
      lists_[block][0] = std::int32_t(end);
      end += std::size_t(std::exchange(lists_[block][1], 0));
    }
    lists_.resize(end);
    for (const FacetBox& box : boxes)
      for_blocks(box, [&](std::size_t block) {
        lists_[std::size_t(lists_[block][0] + lists_[block][1]++)] = packed_box(box, first_facet);
      });
  }

  void write_contents() {
    const bool lost = on_card_->content.reserve(content_texels_, row_bits_, most_rows_);
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

  /// Draws into a texture, or one of its layers, from here on.
  void target(GLuint texture, int layer) const {
    glBindFramebuffer(GL_FRAMEBUFFER, on_card_->framebuffer.name());
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, 0);
    if (layer < 0)
      glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
    else
      glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, texture, 0, layer);
  }

  void use(const Program& program) const {
    const GLuint name = program.name();
    glUseProgram(name);
    const auto at = [&](const char* uniform) { return glGetUniformLocation(name, uniform); };
    const std::pair<const char*, int> units[] = {{"u_lists", kListsUnit},     {"u_numbers", kNumbersUnit},
                                                 {"u_content", kContentUnit}, {"u_rays", kRaysUnit},
                                                 {"u_hits", kHitsUnit},       {"u_edges", kEdgesUnit},
                                                 {"u_taps", kTapsUnit},       {"u_values", kValuesUnit}};
    for (const auto& [uniform, unit] : units) glUniform1i(at(uniform), unit);
    const render::TileGrid grid = lens_.grid();
    glUniform1i(at("u_row_bits"), row_bits_);
    glUniform2i(at("u_frame"), grid.frame.width, grid.frame.height);
    glUniform2i(at("u_tiles"), grid.across(), grid.down());
    glUniform1i(at("u_first_tile"), GLint(first_tile_));
    glUniform1i(at("u_has_lens"), has_lens_);
    const Eigen::Matrix3f direction_from_pixel =
        projector_->inverse_camera.intrinsics.matrix().inverse().cast<float>();
    glUniformMatrix3fv(at("u_direction_from_pixel"), 1, GL_FALSE, direction_from_pixel.data());
    glUniform1i(at("u_right_steps"), !area() && !options_.linear_light ? 128 : 512);
    glBindVertexArray(on_card_->nothing.name());
    on_card_->lists.bind();
    on_card_->numbers.bind();
    on_card_->content.bind();
    on_card_->rays.bind();
    if (layers_cast_ > 0) on_card_->hits.bind();
  }
  static void uniform(const Program& program, const char* name, int value) {
    glUniform1i(glGetUniformLocation(program.name(), name), value);
  }

  void cast(bool new_lens) {
    const render::TileGrid grid = lens_.grid();
    const int width = grid.frame.width, height = grid.frame.height;
    OnCard& card = *on_card_;
    if (layers_cast_ > 0) {
      const bool lost = card.hits.resize(width + 2, height + 2, layers_cast_);
      find_hits(new_lens || lost);
    }
    if (layers_cast_ == 0) return;
    card.edges.resize(width, height);
    card.stencil.resize(width, height);
    target(card.edges.name(), -1);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER,
                              card.stencil.name());
    glViewport(0, 0, width, height);
    const GLint none[4] = {0, 0, 0, 0};
    glClearBufferiv(GL_COLOR, 0, none);
    glClearBufferiv(GL_STENCIL, 0, none);
    glEnable(GL_STENCIL_TEST);
    glStencilFunc(GL_ALWAYS, 1, 0xff);
    glStencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
    use(card.find_edges);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glDisable(GL_STENCIL_TEST);
    if (!area()) return;
    card.taps.resize(grid.across() * kBlocksAcross, grid.down() * kBlocksDown, tap_layers_);
    use(card.choose_taps);
    glViewport(0, 0, card.taps.width(), card.taps.height());
    for (std::size_t i = 0; i < items_.size(); ++i) {
      if (!cast_at_[i]) continue;
      uniform(card.choose_taps, "u_item", int(i));
      for (int n = 0; n < (items_[i].mask.view.empty() ? 1 : 2); ++n) {
        target(card.taps.name(), items_[i].records()[std::size_t(n)]->layer);
        uniform(card.choose_taps, "u_record", 2 * int(i) + n);
        glDrawArrays(GL_TRIANGLES, 0, 3);
      }
    }
  }

  void find_hits(bool all) {
    OnCard& card = *on_card_;
    const int width = card.hits.width(), height = card.hits.height();
    card.depth.resize(width, height);
    glViewport(0, 0, width, height);
    for (std::size_t i = 0; i < items_.size(); ++i) {
      // Another item's change may have given it another layer or other numbers for its facets.
      const Item& item = items_[i];
      const std::pair<int, std::size_t> cast_for{cast_at_[i] ? item.layer : -1, item.first_facet};
      if (cast_for_.size() <= i) cast_for_.resize(i + 1, {-1, 0});
      const bool same = !all && !item.new_map && cast_for_[i] == cast_for;
      cast_for_[i] = cast_for;
      if (same || !cast_at_[i]) continue;
      target(card.hits.name(), item.layer);
      if (!layers_[i].is_mesh()) {
        use(card.find_plane_hits);
        uniform(card.find_plane_hits, "u_facet", int(item.first_facet));
        glDrawArrays(GL_TRIANGLES, 0, 3);
        continue;
      }
      use(card.find_hits);
      glEnable(GL_DEPTH_TEST);
      glDepthFunc(GL_LESS);
      glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, card.depth.name());
      const GLint none[4] = {-1, 0, 0, 0};
      const GLfloat far = 1;
      glClearBufferiv(GL_COLOR, 0, none);
      glClearBufferfv(GL_DEPTH, 0, &far);
      uniform(card.find_hits, "u_first_box", GLint(first_box_[i]));
      glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, GLsizei(layers_[i].room->boxes().count));
      glDisable(GL_DEPTH_TEST);
    }
  }

  /// Into `drawn`, first row first.
  void draw(const Scene& scene) const {
    OnCard& card = *on_card_;
    const ImageSize frame = lens_.grid().frame;
    card.drawn.resize(frame.width, frame.height);
    target(card.drawn.name(), -1);
    glViewport(0, 0, frame.width, frame.height);
    if (layers_cast_ > 0) {
      glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER,
                                card.stencil.name());
      glEnable(GL_STENCIL_TEST);
      glStencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
    }
    for (const bool edges : {false, true}) {
      if (edges && layers_cast_ == 0) continue;
      glStencilFunc(GL_EQUAL, edges, 0xff);
      const Program& program = edges ? card.draw_edges : card.draw;
      use(program);
      card.values.bind();
      if (layers_cast_ > 0) card.edges.bind();
      if (layers_cast_ > 0 && area()) card.taps.bind();
      const std::uint8_t* const b = scene.background;
      glUniform3i(glGetUniformLocation(program.name(), "u_background"), curve_.light(b[0]),
                  curve_.light(b[1]), curve_.light(b[2]));
      uniform(program, "u_area", area());
      glDrawArrays(GL_TRIANGLES, 0, 3);
    }
    glDisable(GL_STENCIL_TEST);
  }

  /// What was drawn, into the top left corner of a framebuffer.
  void copy(GLuint framebuffer, int rows) const {
    const ImageSize frame = lens_.grid().frame;
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
    glViewport(0, rows - frame.height, frame.width, frame.height);
    glUseProgram(on_card_->copy.name());
    on_card_->drawn.bind();
    uniform(on_card_->copy, "u_drawn", kTapsUnit);
    uniform(on_card_->copy, "u_rows", rows);
    glDrawArrays(GL_TRIANGLES, 0, 3);
  }

  void read(ImageView<std::uint8_t> frame) {
    read_.resize(std::size_t(frame.width) * std::size_t(frame.height) * 4);
    glReadPixels(0, 0, frame.width, frame.height, GL_RGBA, GL_UNSIGNED_BYTE, read_.data());
    check("drawing");
    const auto to_rgb = render::best_kernels().values_to_rgb;
    for (int y = 0; y < frame.height; ++y)
      to_rgb(read_.data() + std::size_t(y) * std::size_t(frame.width) * 4, frame.width, frame.row(y));
  }

  RenderOptions options_;
  render::LightCurve curve_;
  render::Workers workers_;
  std::unique_ptr<OwnContext> own_;
  std::string device_;
  int row_bits_ = 0, most_rows_ = 0;
  std::unique_ptr<OnCard> on_card_;

  const Projector* projector_ = nullptr;  ///< of the frame that is drawn
  render::LensMap lens_;
  bool has_lens_ = false;
  std::vector<Item> items_;
  std::vector<Layer> layers_;
  TileSteps steps_;
  std::vector<Int4> lists_;
  std::vector<Float4> numbers_;
  std::size_t first_tile_ = 0, content_texels_ = 0;
  std::vector<std::size_t> first_box_;
  std::vector<std::pair<int, std::size_t>> cast_for_;
  std::vector<bool> cast_at_;  ///< items that are cast at on some tile
  bool moved_contents_ = false;
  int layers_cast_ = 0;              ///< items of these
  int tap_layers_ = 0;               ///< their contents and masks
  std::vector<std::uint8_t> alpha_;  ///< of a mask, while it is prepared
  std::vector<std::uint8_t> read_;
};

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
const std::string& GlRenderer::device() const {
  return state_->device();
}

}  // namespace procam::render_gl
