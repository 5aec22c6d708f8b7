#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "context.hpp"
#include "layers.hpp"
#include "light.hpp"
#include "mesh_tile.hpp"
#include "objects.hpp"
#include "procam/render/gl.hpp"
#include "shaders.hpp"

namespace procam::render_gl {

using Int4 = std::array<std::int32_t, 4>;
using Float4 = std::array<float, 4>;

constexpr int kOpaque = 1, kMesh = 2, kNotThroughLens = 4, kMasked = 8;  // as kCommon reads them

/// A frame is (1) placed: maps on the CPU, as the CPU renderer's, and sent where they are new; (2) cast,
/// where they are new: which facet a pixel meets, which pixels are edges, how blocks look; (3) drawn, by a
/// program that walks its tile's steps at each pixel.
class GlRenderer::State {
 public:
  State(const render::RenderOptions& options, Context context);
  ~State();

  const std::string& device() const { return device_; }
  render::RenderWork render(const Scene& scene, const Projector& projector, ImageView<std::uint8_t> frame);
  render::RenderWork draw_current(const Scene& scene, const Projector& projector, int rows);

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

    OnCard();
  };

  std::unique_ptr<OwnContext::Use> used() const {
    return own_ ? std::make_unique<OwnContext::Use>(*own_) : nullptr;
  }
  bool area() const { return options_.filter == render::Filter::kArea; }
  static void check(const char* what);

  // (1), gl.cpp and lists.cpp
  void write_values();
  render::RenderWork prepare(const Scene& scene, const Projector& projector);
  /// Returns whether its levels are others than before.
  template <typename Convert>
  bool prepare(ViewU8 view, std::uint64_t revision, int levels, const Convert& convert, Shown& ready);
  /// Direction of each pixel's ray, and of those one beyond the frame; where there is a lens.
  void write_rays();
  void write_contents();
  /// Facets of all items; those of a plane or pixel surface are one.
  void write_numbers();
  /// Where the levels of the contents and masks lie.
  void place_contents();
  void write_lists();
  /// The steps of a tile, and what they refer to.
  void add_tile(int x, int y);
  /// For each block of a tile, the first of its boxes and their number; then these. (An edge pixel looks at
  /// all of its block's, and a tile may hold a thousand.)
  void add_boxes(const render::FacetBoxes& boxes, std::size_t first_facet, const render::PixelRect& tile);

  // (2) and (3), passes.cpp
  /// Draws into a texture, or one of its layers, from here on.
  void target(GLuint texture, int layer) const;
  void use(const Program& program) const;
  void cast(bool new_lens);
  void find_hits(bool all);
  /// Into `drawn`, first row first.
  void draw(const Scene& scene) const;
  /// What was drawn, into the top left corner of a framebuffer.
  void copy(GLuint framebuffer, int rows) const;
  void read(ImageView<std::uint8_t> frame);

  render::RenderOptions options_;
  render::LightCurve curve_;
  render::Workers workers_;
  std::unique_ptr<OwnContext> own_;
  std::string device_;
  int row_bits_ = 0, max_rows_ = 0;
  std::unique_ptr<OnCard> on_card_;

  const Projector* projector_ = nullptr;  ///< of the frame that is drawn
  render::LensMap lens_;
  bool has_lens_ = false;
  std::vector<Item> items_;
  std::vector<render::Layer> layers_;
  render::TileSteps steps_;
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

}  // namespace procam::render_gl
