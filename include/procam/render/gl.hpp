#pragma once
/// Draws a scene into a projector's frame by OpenGL: the picture of render::CpuRenderer, on a graphics card.
///
///   render_gl::GlRenderer renderer;                       // a context of its own, no window needed
///   renderer.render(scene, projector, frame);             // into memory
///
///   render_gl::GlRenderer renderer({}, render_gl::Context::kCurrent);   // in a window's context
///   renderer.draw(scene, projector, 1080);                              // into the window
///
/// OpenGL 3.3 core or OpenGL ES 3.0. A fragment shader follows each pixel's light as render/cpu.hpp says,
/// through the same lens map, footprints and samples, in the same integers: values differ from the CPU's by
/// at most 2 of 255 on 99.9 % of the pixels (tests/render_gl; measured figures in docs/render-measured.md). What a
/// moved surface needs (a mesh's triangles in the projector's frame, where planes lie on the tiles) is worked
/// out on the CPU and sent to the card; a scene that stands still sends nothing.
///
/// Fails with Error(kDevice) where no such context can be had or the scene needs more than the card holds,
/// and with Error(kUnsupported) in a build without OpenGL.
#include <memory>
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/render/cpu.hpp"

namespace procam::render_gl {

enum class Context {
  kOwn,      ///< made by the renderer through EGL, without a window; current only while the renderer works
  kCurrent,  ///< the one that is current where the renderer is made, and must be at each of its calls
};

/// Draws frame after frame and keeps what the next one can use, on the card: as render::CpuRenderer does, by
/// the same rules (content_revision, places in the scene). Belongs to one thread at a time.
class PROCAM_EXPORT GlRenderer : public render::Renderer {
 public:
  /// Of the options, `threads` are those that prepare pictures and maps; `vector_bits` have no meaning here.
  explicit GlRenderer(const render::RenderOptions& options = {}, Context context = Context::kOwn);
  GlRenderer(GlRenderer&&) noexcept;
  GlRenderer& operator=(GlRenderer&&) noexcept;
  ~GlRenderer() override;

  /// Draws into memory: a frame of the projector's size with 3 channels (RGB); every pixel is written.
  /// Throws std::invalid_argument as CpuRenderer::render does.
  render::RenderWork render(const Scene& scene, const Projector& projector,
                            ImageView<std::uint8_t> frame) override;
  /// Throws Error(kUnsupported): frames of OpenGL have 8 bits a channel.
  render::RenderWork render(const Scene& scene, const Projector& projector, ImageView<float> frame) override;

  /// Draws into the framebuffer that is bound for drawing, which is `rows` high (OpenGL counts them from
  /// below) and not smaller than the projector's frame: the frame's first pixel comes to its top left corner,
  /// as in a window. The state that the caller had is put back. Only with Context::kCurrent.
  render::RenderWork draw(const Scene& scene, const Projector& projector, int rows);

  /// Who draws, in the driver's words: renderer and version.
  std::string device() const override;

 private:
  class State;
  std::unique_ptr<State> state_;
};

/// The renderer of a name: "cpu" or "gl". Throws Error(kInput) for another name, and what GlRenderer throws.
PROCAM_EXPORT std::unique_ptr<render::Renderer> open_renderer(const std::string& name,
                                                              const render::RenderOptions& options = {});

}  // namespace procam::render_gl
