#include "context.hpp"

#include <dlfcn.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <array>
#include <functional>
#include <vector>

#include "procam/core/base/error.hpp"

namespace procam::render_gl {

namespace {

constexpr int kOldestGl = 33, kOldestGles = 30;  // as epoxy numbers them

/// epoxy ends the program where a library is missing: ask first.
bool have_library(const char* name) {
  return dlopen(name, RTLD_LAZY | RTLD_GLOBAL) != nullptr;  // stays open, as epoxy's own does
}

bool has(const char* extensions, const std::string& name) {
  return extensions && (" " + std::string(extensions) + " ").find(" " + name + " ") != std::string::npos;
}

std::string egl_fault(const char* call) {
  char code[8];
  std::snprintf(code, sizeof code, "0x%04x", unsigned(eglGetError()));
  return std::string(call) + " failed (" + code + ")";
}

struct Candidate {
  std::string name;
  EGLDisplay display;
};

/// Cards first, then what draws on the CPU.
std::vector<Candidate> candidates() {
  std::vector<Candidate> cards, others;
  const char* const client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  const bool platforms = has(client, "EGL_EXT_platform_base");
  if (platforms && has(client, "EGL_EXT_platform_device") &&
      (has(client, "EGL_EXT_device_base") || has(client, "EGL_EXT_device_enumeration"))) {
    std::array<EGLDeviceEXT, 16> devices{};
    EGLint count = 0;
    if (eglQueryDevicesEXT(EGLint(devices.size()), devices.data(), &count))
      for (int i = 0; i < count; ++i) {
        const EGLDeviceEXT device = devices[std::size_t(i)];
        const char* const kind = eglQueryDeviceStringEXT(device, EGL_EXTENSIONS);
        const bool software = has(kind, "EGL_MESA_device_software");
        (software ? others : cards)
            .push_back({"EGL device " + std::to_string(i),
                        eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, device, nullptr)});
      }
  }
  if (platforms && has(client, "EGL_MESA_platform_surfaceless"))
    cards.push_back({"Mesa without surfaces",
                     eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr)});
  cards.insert(cards.end(), others.begin(), others.end());
  cards.push_back({"the default display", eglGetDisplay(EGL_DEFAULT_DISPLAY)});
  return cards;
}

std::string version_words() {
  const auto* const words = reinterpret_cast<const char*>(glGetString(GL_VERSION));
  return words ? words : "no version";
}

[[noreturn]] void refuse_context(const std::string& why) {
  throw Error(ErrorKind::kDevice, "OpenGL without a window", why,
              "install a driver with EGL (on Debian libegl1 and libgl1-mesa-dri, which needs no card), or "
              "draw on the CPU");
}

/// What the shaders are written for, and how EGL is asked for it.
struct Api {
  EGLenum api;
  EGLint renderable;
  std::vector<EGLint> attributes;
};
std::vector<Api> usable_apis() {
  std::vector<Api> apis;
  if (have_library("libOpenGL.so.0") || have_library("libGL.so.1"))
    apis.push_back(
        {EGL_OPENGL_API,
         EGL_OPENGL_BIT,
         {EGL_CONTEXT_MAJOR_VERSION_KHR, 3, EGL_CONTEXT_MINOR_VERSION_KHR, 3,
          EGL_CONTEXT_OPENGL_PROFILE_MASK_KHR, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT_KHR, EGL_NONE}});
  if (have_library("libGLESv2.so.2"))
    apis.push_back({EGL_OPENGL_ES_API, EGL_OPENGL_ES3_BIT_KHR, {EGL_CONTEXT_CLIENT_VERSION, 3, EGL_NONE}});
  return apis;
}

}  // namespace

struct OwnContext::Handles {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;
  EGLSurface surface = EGL_NO_SURFACE;
};

struct OwnContext::Use::Before {
  EGLenum api = eglQueryAPI();
  EGLDisplay own_display = EGL_NO_DISPLAY;
  EGLDisplay display = eglGetCurrentDisplay();
  EGLContext context = eglGetCurrentContext();
  EGLSurface draw = eglGetCurrentSurface(EGL_DRAW), read = eglGetCurrentSurface(EGL_READ);
};

OwnContext::OwnContext() : handles_(std::make_unique<Handles>()) {
  if (!have_library("libEGL.so.1")) refuse_context("there is no libEGL.so.1");
  const std::vector<Api> apis = usable_apis();
  if (apis.empty()) refuse_context("there is neither libOpenGL.so.0, libGL.so.1 nor libGLESv2.so.2");

  std::string faults;
  for (const Candidate& candidate : candidates()) {
    const auto add_fault = [&](const std::string& why) {
      faults += (faults.empty() ? "" : "; ") + candidate.name + ": " + why;
    };
    // A display is not ended again: others in this process may use it, and EGL does not count them.
    if (candidate.display == EGL_NO_DISPLAY || !eglInitialize(candidate.display, nullptr, nullptr)) {
      add_fault(egl_fault("eglInitialize"));
      continue;
    }
    handles_->display = candidate.display;
    const char* const extensions = eglQueryString(candidate.display, EGL_EXTENSIONS);
    const bool surfaceless = has(extensions, "EGL_KHR_surfaceless_context");
    for (const Api& api : apis) {
      if (!eglBindAPI(api.api)) continue;
      const EGLint wanted[] = {EGL_SURFACE_TYPE, surfaceless ? 0 : EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                               api.renderable, EGL_NONE};
      EGLConfig config = nullptr;
      EGLint count = 0;
      if (!eglChooseConfig(candidate.display, wanted, &config, 1, &count) || count < 1) {
        if (!has(extensions, "EGL_KHR_no_config_context") || !surfaceless) {
          add_fault("no configuration to draw with");
          continue;
        }
        config = nullptr;  // none is needed
      }
      handles_->context = eglCreateContext(candidate.display, config, EGL_NO_CONTEXT, api.attributes.data());
      if (handles_->context == EGL_NO_CONTEXT) {
        add_fault(egl_fault(api.api == EGL_OPENGL_API ? "a context for OpenGL 3.3 core: eglCreateContext"
                                                      : "a context for OpenGL ES 3: eglCreateContext"));
        continue;
      }
      if (!surfaceless) {
        const EGLint one_pixel[] = {EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
        handles_->surface = eglCreatePbufferSurface(candidate.display, config, one_pixel);
      }
      try {
        const Use use(*this);
        require_current_context();
        return;
      } catch (const Error& error) {
        add_fault(error.why());
      }
      if (handles_->surface != EGL_NO_SURFACE) eglDestroySurface(candidate.display, handles_->surface);
      eglDestroyContext(candidate.display, handles_->context);
      *handles_ = Handles{candidate.display};
    }
  }
  handles_->context = EGL_NO_CONTEXT;
  refuse_context(faults.empty() ? "EGL offers no display" : faults);
}

OwnContext::~OwnContext() {
  if (handles_->context == EGL_NO_CONTEXT) return;
  if (handles_->surface != EGL_NO_SURFACE) eglDestroySurface(handles_->display, handles_->surface);
  eglDestroyContext(handles_->display, handles_->context);
}

OwnContext::Use::Use(const OwnContext& context) : before_(std::make_unique<Before>()) {
  const Handles& h = *context.handles_;
  before_->own_display = h.display;
  if (!eglMakeCurrent(h.display, h.surface, h.surface, h.context))
    throw Error(ErrorKind::kDevice, "OpenGL without a window", egl_fault("eglMakeCurrent"),
                "use a renderer in one thread at a time");
}

OwnContext::Use::~Use() {
  if (before_->context != EGL_NO_CONTEXT)
    eglMakeCurrent(before_->display, before_->draw, before_->read, before_->context);
  else
    eglMakeCurrent(before_->own_display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglBindAPI(before_->api);
}

void require_current_context() {
  const auto refuse = [](const std::string& why) {
    throw Error(ErrorKind::kDevice, "the current OpenGL context", why,
                "make a context for OpenGL 3.3 core or OpenGL ES 3.0 current, or draw on the CPU");
  };
  if (!have_library("libOpenGL.so.0") && !have_library("libGL.so.1") && !have_library("libGLESv2.so.2"))
    refuse("this machine has no OpenGL library");
  const int version = epoxy_gl_version();
  if (version == 0) refuse("there is none");
  if (version < (epoxy_is_desktop_gl() ? kOldestGl : kOldestGles)) refuse("it is " + version_words());
}

}  // namespace procam::render_gl
