#pragma once
/// Defocus of cameras and projectors.
#include "procam/core/lens/camera.hpp"

namespace procam::simulate {

/// A lens of which one distance is in focus. A point at depth z along the axis becomes a disc of
///
///   diameter = aperture f |1/z - 1/focus|   pixels,   f = sqrt(fx fy)
///
/// As f = image distance / pixel, this is exact for the thin lens. Discs of more than 48 pixels are drawn
/// with 48.
struct ThinLens {
  double aperture = 0;  ///< diameter, metres: focal length / f-number; 0: all is in focus
  double focus = 1;     ///< depth of the plane in focus, metres
};

}  // namespace procam::simulate
