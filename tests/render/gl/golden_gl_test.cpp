/// The pictures that the CPU renderer is held to, by OpenGL.
#include <memory>

#include "procam/render/gl.hpp"
#include "render/golden.hpp"
#include "render/golden_scenes.hpp"

namespace procam {
namespace {

// A renderer for each kind of options: drivers compile programs for each.
TEST(GoldenGl, EverySurfaceAndFilter) {
  std::map<std::pair<render::Filter, bool>, std::unique_ptr<render_gl::GlRenderer>> renderers;
  for (const GoldenScene& golden : golden_scenes()) {
    auto& renderer = renderers[{golden.options.filter, golden.options.linear_light}];
    if (!renderer) renderer = std::make_unique<render_gl::GlRenderer>(golden.options);
    ImageU8 drawn(golden.projector.size(), 3);
    renderer->render(golden.scene, golden.projector, drawn);
    expect_golden(golden.name, "gl", drawn);
  }
}

}  // namespace
}  // namespace procam
