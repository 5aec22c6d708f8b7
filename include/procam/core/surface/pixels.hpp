#pragma once
/// A surface given in the projector's own pixels.
#include "procam/core/base/types.hpp"

namespace procam {

/// N >= 4 pairs of content coordinates and projector pixels, as clicked or dragged: a pure homography, right
/// for one placement of the projector. The projector's lens is not applied: whoever dragged the corners saw
/// it already.
struct PixelSurface {
  Points2 content;  ///< source (u, v)
  Points2 pixels;   ///< destination, projector pixels
};

/// A pixel surface, solved.
struct PlacedPixels {
  Mat3 pixel_from_content = Mat3::Identity();  ///< (u, v, 1) -> projector pixel
};

}  // namespace procam
