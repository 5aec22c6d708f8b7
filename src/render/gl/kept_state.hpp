#pragma once
#include <epoxy/gl.h>

#include <array>
#include <cstddef>

namespace procam::render_gl {

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

}  // namespace procam::render_gl
