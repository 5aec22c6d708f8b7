#pragma once
/// Small marks on plane surfaces, where the content has no texture that a camera could compare (watch.hpp).
///
///   watch::Marks marks;
///   marks.draw(light_time, scene, projector, frame);  // after the frame is rendered, before masks over people
///
/// A mark is a disc in the frame with four quadrants: two are brighter than the content by `contrast`, two are darker. So
/// one half shows on white, the other on black, and the edges give both directions of a shift. The marks are part of the
/// frame: the watch predicts them as it does all content.
///
/// Each plane surface has ten: along the border of its content, at 1/11, 4/11, 7/11, 10/11 of the width and 1/8, 1/2, 7/8
/// of the height. A mark is omitted where its disc leaves the content or the content's mask, or where no light goes.
///
/// A mark is drawn while the content around it has little texture: the smaller eigenvalue of its structure tensor is less
/// than a twelfth of that of a mark on grey. Twice that removes the mark. It fades in and out.
#include <array>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/core/surface/scene.hpp"

namespace procam::watch {

struct MarkOptions {
  double diameter = 0.03;  ///< share of the frame's width
  double contrast = 96;    ///< sRGB levels of 255, up and down
  double fade = 1;         ///< seconds from nothing to full contrast
};

class PROCAM_EXPORT Marks {
 public:
  /// Throws std::invalid_argument for options out of range.
  explicit Marks(const MarkOptions& options = {});

  /// Draws into the frame of this scene. `time` in seconds; marks that were not there before begin at full contrast, or
  /// none. The same calls in the same order draw the same marks.
  void draw(double time, const Scene& scene, const Projector& projector, ImageView<std::uint8_t> frame);

  static constexpr int kMarksOfSurface = 10;

 private:
  struct Mark {
    bool is_known = false;  ///< was somewhere in the last frame
    bool is_needed = false;
    double strength = 0;  ///< 0..1
  };
  void update(Mark& mark, const Vec2& centre, double seconds, ViewU8 frame) const;

  MarkOptions options_;
  std::vector<std::array<Mark, kMarksOfSurface>> marks_;  ///< of each item of the scene
  double time_ = 0;                                       ///< of the last frame
};

}  // namespace procam::watch
