#pragma once
/// An OpenGL context without a window, by EGL.
#include <memory>
#include <string>

namespace procam::render_gl {

class OwnContext {
 public:
  /// Throws Error(kDevice) that lists what was tried.
  OwnContext();
  ~OwnContext();
  OwnContext(const OwnContext&) = delete;
  OwnContext& operator=(const OwnContext&) = delete;

  /// Current while it lives; then what was current before is current again.
  class Use {
   public:
    explicit Use(const OwnContext& context);
    ~Use();
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;

   private:
    struct Before;
    std::unique_ptr<Before> before_;
  };

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
};

/// Throws Error(kDevice) unless a context is current that can draw: OpenGL 3.3 or OpenGL ES 3.0.
void require_current_context();

}  // namespace procam::render_gl
