#pragma once
/// A projector as the camera of another program: what to set there so that its picture, sent to the
/// projector, is where procam computes. Text that can be pasted into the program or its file.
///
///   const CameraSettings settings = camera_settings(CameraProgram::kBlender, rig.projector(), pose);
///   std::cout << settings.text;
///
/// No program's camera has lens distortion. Only the projection matrices of Unity and OpenGL can express skew. Unreal, Godot
/// and Splash have square pixels only: unequal focal lengths change the size of the image to draw
/// (`render_size`), which the program or the window stretches to the projector's size. `diagnostics` names
/// every loss in pixels; avoid it with a warp map (export-warp).
///
/// Each program's formula is restated in tests/io/camera_settings_test.cpp with its source. See
/// docs/exchange.md.
#include <map>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/io/exchange/world_axes.hpp"

namespace procam::io {

enum class CameraProgram { kUnity, kUnreal, kGodot, kBlender, kSplash, kSgct, kOpenGl };

/// "unity", "unreal", "godot", "blender", "splash", "sgct", "opengl"; else Error(kInput).
PROCAM_EXPORT CameraProgram parse_camera_program(const std::string& name);

struct ClipPlanes {
  double near = 0.1, far = 100;  ///< metres
};

struct CameraSettings {
  std::string text;
  std::map<std::string, std::vector<double>> values;  ///< the numbers of the text, by their name there
  ImageSize render_size;                              ///< the picture to draw, at least the projector's
  Diagnostics diagnostics;  ///< warnings "skew_lost", "distortion_lost", notes "render_size", "godot_3_size"
};

/// Throws std::invalid_argument for clip planes that are not 0 < near < far < infinity.
PROCAM_EXPORT CameraSettings camera_settings(CameraProgram program, const RigProjector& projector,
                                             const Pose& world_from_projector, WorldUp up,
                                             ClipPlanes clip = {});

}  // namespace procam::io
