#pragma once
/// A display for a context of the caller's own, as a test or a benchmark makes it.
#include <epoxy/egl.h>

#include <cstring>

namespace procam {

/// The first EGL device that is not software, as GlRenderer chooses, else Mesa's display without surfaces. A
/// driver of a card does not have to offer the latter.
inline EGLDisplay display_of_card() {
  EGLDeviceEXT devices[16];
  EGLint count = 0;
  if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_enumeration") ||
      epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_base"))
    eglQueryDevicesEXT(16, devices, &count);
  for (EGLint i = 0; i < count; ++i) {
    const char* const extensions = eglQueryDeviceStringEXT(devices[i], EGL_EXTENSIONS);
    if (extensions && std::strstr(extensions, "EGL_MESA_device_software")) continue;
    const EGLDisplay display = eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr);
    if (display != EGL_NO_DISPLAY && eglInitialize(display, nullptr, nullptr)) return display;
  }
  return eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
}

}  // namespace procam
