/// GlRenderer in a context of the caller's, as of a window's: the picture comes the right way up, and the
/// caller's state stays as it was.
#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include "procam/core/base/error.hpp"
#include "procam/render/gl.hpp"
#include "render/gl/display_of_card.hpp"
#include "render/rooms.hpp"

namespace procam {
namespace {

using render_gl::Context;
using render_gl::GlRenderer;

/// A caller's context, for OpenGL or OpenGL ES.
class CallersContext {
 public:
  explicit CallersContext(EGLenum api) {
    display_ = display_of_card();
    if (!eglInitialize(display_, nullptr, nullptr) || !eglBindAPI(api)) return;
    const EGLint wanted[] = {EGL_SURFACE_TYPE, 0, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint count = 0;
    eglChooseConfig(display_, wanted, &config, 1, &count);
    const EGLint gl[] = {EGL_CONTEXT_MAJOR_VERSION_KHR, 3, EGL_CONTEXT_MINOR_VERSION_KHR, 3, EGL_NONE};
    const EGLint gles[] = {EGL_CONTEXT_CLIENT_VERSION, 3, EGL_NONE};
    context_ = eglCreateContext(display_, config, EGL_NO_CONTEXT, api == EGL_OPENGL_API ? gl : gles);
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_);
  }
  ~CallersContext() {
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (context_ != EGL_NO_CONTEXT) eglDestroyContext(display_, context_);
  }
  CallersContext(const CallersContext&) = delete;
  CallersContext& operator=(const CallersContext&) = delete;
  bool is_current() const { return context_ != EGL_NO_CONTEXT && eglGetCurrentContext() == context_; }

 private:
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

/// A green sheet with a red top left quarter before a blue background, and a ball.
struct Shown {
  Projector projector{Camera{{160, 100}, {300, 290, 70, 95, 0.6}, brown(-0.1)}};
  ImageU8 picture{80, 60, 3, 0}, white{8, 6, 4, 255};
  Scene scene;

  Shown() {
    for (int y = 0; y < 60; ++y)
      for (int x = 0; x < 80; ++x) picture.at(x, y, x < 40 && y < 30 ? 0 : 1) = 230;
    scene.background[2] = 77;
    scene.items = {{tilted_sheet(projector, 0.7, 0.5, 2, 20, Vec2(75, 48)).placement, picture}};
    SphereSurface ball;
    ball.radius = 0.12;
    ball.left = -kPi;
    ball.right = kPi;
    ball.top = kPi / 2;
    ball.bottom = -kPi / 2;
    scene.items.push_back({PlacedMesh{mesh_of(Surface{"ball", ball, {}, ""}),
                                      Pose(Mat3::Identity(), 1.6 * projector.emit(Vec2(90, 60))->direction)},
                           white});
  }
};

int apart(const ImageU8& a, const ImageU8& b) {
  int count = 0;
  for (int y = 0; y < a.height(); ++y)
    for (int x = 0; x < a.width(); ++x)
      for (int c = 0; c < 3; ++c) count += std::abs(a.at(x, y, c) - b.at(x, y, c)) > 2;
  return count;
}

void expect_drawn_into_framebuffer(EGLenum api) {
  const CallersContext context(api);
  if (!context.is_current()) GTEST_SKIP() << "this driver has no such context";
  const Shown shown;
  const ImageU8 expected = render::render(shown.scene, shown.projector);
  constexpr int kWidth = 200, kRows = 130;  // larger than the frame
  GLuint texture = 0, framebuffer = 0, own = 0;
  glGenTextures(1, &texture);
  glActiveTexture(GL_TEXTURE2);
  glBindTexture(GL_TEXTURE_2D, texture);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, kWidth, kRows, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glGenFramebuffers(1, &framebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
  glClearColor(1, 0, 1, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  glGenVertexArrays(1, &own);
  glBindVertexArray(own);

  // What would spoil the picture if it were not reset.
  glEnable(GL_BLEND);
  glEnable(GL_CULL_FACE);
  glCullFace(GL_FRONT_AND_BACK);
  glEnable(GL_SCISSOR_TEST);
  glScissor(3, 4, 5, 6);
  glEnable(GL_STENCIL_TEST);
  glStencilFunc(GL_NEVER, 3, 0x7f);
  glColorMask(GL_TRUE, GL_FALSE, GL_TRUE, GL_TRUE);
  glViewport(1, 2, 3, 4);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 8);
  glPixelStorei(GL_PACK_ROW_LENGTH, 999);

  GlRenderer renderer({}, Context::kCurrent);
  for (int frame = 0; frame < 2; ++frame) renderer.draw(shown.scene, shown.projector, kRows);
  ImageU8 read(shown.projector.size(), 3);
  renderer.render(shown.scene, shown.projector, read);  // the same renderer, into memory

  EXPECT_TRUE(glIsEnabled(GL_BLEND) && glIsEnabled(GL_CULL_FACE) && glIsEnabled(GL_SCISSOR_TEST) &&
              glIsEnabled(GL_STENCIL_TEST));
  const auto state = [](GLenum name) {
    GLint value[4] = {};
    glGetIntegerv(name, value);
    return value[0];
  };
  EXPECT_EQ(state(GL_STENCIL_FUNC), GL_NEVER);
  EXPECT_EQ(state(GL_STENCIL_BACK_VALUE_MASK), 0x7f);
  EXPECT_EQ(state(GL_VIEWPORT), 1);
  EXPECT_EQ(state(GL_UNPACK_ALIGNMENT), 8);
  EXPECT_EQ(state(GL_PACK_ROW_LENGTH), 999);
  EXPECT_EQ(state(GL_ACTIVE_TEXTURE), GL_TEXTURE2);
  EXPECT_EQ(state(GL_TEXTURE_BINDING_2D), GLint(texture));
  EXPECT_EQ(state(GL_DRAW_FRAMEBUFFER_BINDING), GLint(framebuffer));
  EXPECT_EQ(state(GL_VERTEX_ARRAY_BINDING), GLint(own));
  EXPECT_EQ(state(GL_CURRENT_PROGRAM), 0);
  EXPECT_EQ(glGetError(), GLenum(GL_NO_ERROR));

  glPixelStorei(GL_PACK_ROW_LENGTH, 0);
  std::vector<std::uint8_t> pixels(std::size_t(kWidth) * kRows * 4);
  glReadPixels(0, 0, kWidth, kRows, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
  ImageU8 drawn(shown.projector.size(), 3);
  int spilt = 0;
  for (int row = 0; row < kRows; ++row)
    for (int x = 0; x < kWidth; ++x) {
      const std::uint8_t* const pixel = &pixels[std::size_t(row * kWidth + x) * 4];
      const int y = kRows - 1 - row;
      if (x < drawn.width() && y < drawn.height())
        std::copy_n(pixel, 3, &drawn.at(x, y));
      else
        spilt += !(pixel[0] == 255 && pixel[1] == 0 && pixel[2] == 255);
    }
  EXPECT_EQ(spilt, 0) << "pixels beside the frame";
  EXPECT_LE(apart(drawn, expected), 16);
  EXPECT_LE(apart(read, expected), 16);
}

TEST(GlContext, DrawsIntoTheCallersFramebufferOfOpenGl) {
  expect_drawn_into_framebuffer(EGL_OPENGL_API);
}

TEST(GlContext, DrawsIntoTheCallersFramebufferOfOpenGlEs) {
  expect_drawn_into_framebuffer(EGL_OPENGL_ES_API);
}

TEST(GlContext, LeavesTheCallersContextCurrent) {
  const CallersContext context(EGL_OPENGL_API);
  if (!context.is_current()) GTEST_SKIP() << "this driver has no such context";
  const Shown shown;
  {
    GlRenderer renderer;  // its own, beside the caller's
    EXPECT_TRUE(context.is_current());
    ImageU8 frame(shown.projector.size(), 3);
    renderer.render(shown.scene, shown.projector, frame);
    EXPECT_TRUE(context.is_current());
    EXPECT_LE(apart(frame, render::render(shown.scene, shown.projector)), 16);
  }
  EXPECT_TRUE(context.is_current());
}

TEST(GlContext, RefusesWhereNoneIsCurrent) {
  try {
    const GlRenderer renderer({}, Context::kCurrent);
    FAIL() << "no context is current";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kDevice);
    EXPECT_NE(error.next().find("CPU"), std::string::npos);
  }
}

}  // namespace
}  // namespace procam
