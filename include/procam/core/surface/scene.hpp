#pragma once
/// A scene: what a projector is asked to draw. Placed surfaces, each with the picture on it, back to front.
#include <cstdint>

#include "procam/core/base/image.hpp"
#include "procam/core/surface/surface.hpp"

namespace procam {

struct SceneItem {
  Placement placement;
  ViewU8 content;  ///< 1, 3 (RGB) or 4 (RGBA, straight alpha) channels; must outlive the scene
  /// Another number when the pixels in the same memory have changed (a video's frame number): who keeps
  /// content from one frame to the next looks at this, not at the pixels.
  std::uint64_t content_revision = 0;
  /// Alpha of the content, as if multiplied into its own, over the same area: one channel of any resolution,
  /// (0, 0) .. (1, 1) from its corner to its corner as of the content. Empty: none. Must outlive the scene.
  ViewU8 mask = {};
  std::uint64_t mask_revision = 0;  ///< as content_revision
};

struct Scene {
  std::vector<SceneItem> items;            ///< later ones cover earlier ones
  std::uint8_t background[3] = {0, 0, 0};  ///< RGB where nothing is drawn: no light
};

}  // namespace procam
