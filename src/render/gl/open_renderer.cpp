#include "procam/render/gl.hpp"

namespace procam::render_gl {

std::unique_ptr<render::Renderer> open_renderer(const std::string& name,
                                                const render::RenderOptions& options) {
  if (name == "cpu") return std::make_unique<render::CpuRenderer>(options);
  if (name == "gl") return std::make_unique<GlRenderer>(options);
  throw Error(ErrorKind::kInput, "renderer '" + name + "'", "there is none of this name", "use cpu or gl");
}

render::RenderWork GlRenderer::render(const Scene&, const Projector&, ImageView<float>) {
  throw Error(ErrorKind::kUnsupported, "light by OpenGL", "its frames have 8 bits a channel",
              "draw on the CPU, or write frames of 8 bits (.png)");
}

}  // namespace procam::render_gl
