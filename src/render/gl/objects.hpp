#pragma once
/// OpenGL's objects as values that free themselves. All need the context they were made in.
#include <epoxy/gl.h>

#include <algorithm>
#include <string>
#include <utility>

#include "procam/core/base/error.hpp"

namespace procam::render_gl {

[[noreturn]] inline void refuse(const std::string& what, const std::string& why) {
  throw Error(ErrorKind::kDevice, what, why, "update the graphics driver, show less, or draw on the CPU");
}

/// A name that OpenGL gave, freed by `kFree`.
template <void (*kFree)(GLuint)>
class Object {
 public:
  Object() = default;
  explicit Object(GLuint name) : name_(name) {}
  Object(Object&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  Object& operator=(Object&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  ~Object() {
    if (name_) kFree(name_);
  }
  GLuint name() const { return name_; }

 private:
  GLuint name_ = 0;
};

inline void free_texture(GLuint name) {
  glDeleteTextures(1, &name);
}
inline void free_framebuffer(GLuint name) {
  glDeleteFramebuffers(1, &name);
}
inline void free_renderbuffer(GLuint name) {
  glDeleteRenderbuffers(1, &name);
}
inline void free_vertex_array(GLuint name) {
  glDeleteVertexArrays(1, &name);
}
inline void free_program(GLuint name) {
  glDeleteProgram(name);
}
inline void free_shader(GLuint name) {
  glDeleteShader(name);
}

using Texture = Object<free_texture>;
using Framebuffer = Object<free_framebuffer>;
using Renderbuffer = Object<free_renderbuffer>;
using VertexArray = Object<free_vertex_array>;
using Program = Object<free_program>;
using Shader = Object<free_shader>;

/// A kind of texel.
struct Format {
  GLint internal;
  GLenum format, type;
  int bytes;
};
inline constexpr Format kInt4{GL_RGBA32I, GL_RGBA_INTEGER, GL_INT, 16},
    kShort4{GL_RGBA16I, GL_RGBA_INTEGER, GL_SHORT, 8}, kFloat4{GL_RGBA32F, GL_RGBA, GL_FLOAT, 16},
    kInt{GL_R32I, GL_RED_INTEGER, GL_INT, 4}, kInt2{GL_RG32I, GL_RG_INTEGER, GL_INT, 8},
    kByte{GL_R8UI, GL_RED_INTEGER, GL_UNSIGNED_BYTE, 1}, kRgba{GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, 4};

/// A texture of one level, read texel by texel. Its unit becomes the active one.
class Texels {
 public:
  Texels(const Format& format, int unit) : format_(format), unit_(unit) {}

  /// Of this size, its contents lost where that is another than before; `layers` 0: no array. Returns whether
  /// they are lost.
  bool resize(int width, int height, int layers = 0) {
    if (texture_.name() && width == width_ && height == height_ && layers == layers_) {
      bind();
      return false;
    }
    GLuint name = 0;
    glGenTextures(1, &name);
    texture_ = Texture(name);
    width_ = width;
    height_ = height;
    layers_ = layers;
    bind();
    if (layers == 0)
      glTexImage2D(target(), 0, format_.internal, width, height, 0, format_.format, format_.type, nullptr);
    else
      glTexImage3D(target(), 0, format_.internal, width, height, layers, 0, format_.format, format_.type,
                   nullptr);
    for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
      glTexParameteri(target(), filter, GL_NEAREST);
    for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
      glTexParameteri(target(), wrap, GL_CLAMP_TO_EDGE);
    glTexParameteri(target(), GL_TEXTURE_MAX_LEVEL, 0);
    return true;
  }

  void bind() const {
    glActiveTexture(GLenum(GL_TEXTURE0 + unit_));
    glBindTexture(target(), texture_.name());
  }
  void write(int x, int y, int width, int height, const void* data) const {
    glTexSubImage2D(GL_TEXTURE_2D, 0, x, y, width, height, format_.format, format_.type, data);
  }
  GLuint name() const { return texture_.name(); }
  int width() const { return width_; }
  int height() const { return height_; }
  const Format& format() const { return format_; }

 private:
  GLenum target() const { return layers_ == 0 ? GL_TEXTURE_2D : GL_TEXTURE_2D_ARRAY; }

  Format format_;
  int unit_;
  Texture texture_;
  int width_ = 0, height_ = 0, layers_ = 0;
};

/// What is drawn to beside a texture, and never read.
class Pixels {
 public:
  explicit Pixels(GLenum format) : format_(format) {}

  void resize(int width, int height) {
    if (buffer_.name() && width == width_ && height == height_) return;
    GLuint name = 0;
    glGenRenderbuffers(1, &name);
    buffer_ = Renderbuffer(name);
    width_ = width;
    height_ = height;
    GLint before = 0;
    glGetIntegerv(GL_RENDERBUFFER_BINDING, &before);
    glBindRenderbuffer(GL_RENDERBUFFER, name);
    glRenderbufferStorage(GL_RENDERBUFFER, format_, width, height);
    glBindRenderbuffer(GL_RENDERBUFFER, GLuint(before));
  }
  GLuint name() const { return buffer_.name(); }

 private:
  GLenum format_;
  Renderbuffer buffer_;
  int width_ = 0, height_ = 0;
};

/// Texels counted row by row: memory for the programs, of any length.
class Memory {
 public:
  Memory(const Format& format, int unit) : texels_(format, unit) {}

  /// Room for `count` texels in rows of 2^row_bits, at most `max_rows`; with some to spare, so that a little
  /// more does not cost its contents. Returns whether they are lost.
  bool reserve(std::size_t count, int row_bits, int max_rows) {
    const std::size_t rows = (std::max<std::size_t>(count, 1) + (std::size_t(1) << row_bits) - 1) >> row_bits;
    if (rows > std::size_t(max_rows))
      refuse("OpenGL", "the scene needs a texture of " + std::to_string(rows) + " rows, and " +
                           std::to_string(max_rows) + " is the most here");
    if (rows <= std::size_t(texels_.height())) {
      texels_.bind();
      return false;
    }
    const std::size_t spare = std::min(rows + rows / 4, std::size_t(max_rows));
    return texels_.resize(1 << row_bits, int(spare));
  }

  void write(std::size_t first, std::size_t count, const void* data) const {
    const auto width = std::size_t(texels_.width());
    const char* from = static_cast<const char*>(data);
    texels_.bind();
    while (count > 0) {  // the rest of a row, whole rows, the beginning of a row
      const std::size_t x = first % width, y = first / width;
      const std::size_t rows = x == 0 ? count / width : 0;
      const std::size_t across = rows > 0 ? width : std::min(count, width - x);
      texels_.write(int(x), int(y), int(across), int(std::max<std::size_t>(rows, 1)), from);
      const std::size_t written = across * std::max<std::size_t>(rows, 1);
      from += written * std::size_t(texels_.format().bytes);
      first += written;
      count -= written;
    }
  }
  void bind() const { texels_.bind(); }

 private:
  Texels texels_;
};

}  // namespace procam::render_gl
