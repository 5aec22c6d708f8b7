/// A build without OpenGL.
#include "procam/core/base/error.hpp"
#include "procam/render/gl.hpp"

namespace procam::render_gl {

class GlRenderer::State {};

GlRenderer::GlRenderer(const render::RenderOptions&, Context) {
  throw Error(ErrorKind::kUnsupported, "drawing by OpenGL", "procam was built without it",
              "draw on the CPU, or install libepoxy-dev and libegl-dev and build procam again");
}
GlRenderer::GlRenderer(GlRenderer&&) noexcept = default;
GlRenderer& GlRenderer::operator=(GlRenderer&&) noexcept = default;
GlRenderer::~GlRenderer() = default;

// None can be made: these are never reached.
render::RenderWork GlRenderer::render(const Scene&, const Projector&, ImageView<std::uint8_t>) {
  return {};
}
render::RenderWork GlRenderer::draw(const Scene&, const Projector&, int) {
  return {};
}
std::string GlRenderer::device() const {
  return {};
}

}  // namespace procam::render_gl
