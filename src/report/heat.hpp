#pragma once
/// Colours of a map: one scale for every page.
#include <string>
#include <vector>

#include "procam/core/base/types.hpp"

namespace procam::report {

/// Of a share 0 to 1: pale yellow to dark red; readable in print and with any colour vision, since lightness falls
/// throughout.
std::string heat(double share);

/// A rectangle without an outline, with edges on whole pixels: neighbours leave no seam. `tip` is shown under a
/// resting pointer.
std::string filled(const Vec2& corner, const Vec2& size, const std::string& fill, const std::string& tip);

/// The colours from 0 to 1 as a bar with numbers below, 28 high; `max` names the value at its end.
std::string heat_scale(const Vec2& corner, double width, const std::string& max);

/// Values at pixels of a grid that spans an image.
struct FrameMap {
  ImageSize size;
  int columns = 0, rows = 0;   ///< of the grid, from the image's first pixel to its last
  Points2 pixels;              ///< of the grid that have a value
  std::vector<double> values;  ///< by pixel, in `unit`, not negative
  std::string unit;            ///< "mm"
};

/// The image with a coloured cell round each pixel, some of the values as numbers, and the scale from 0 to the largest;
/// an <svg>.
std::string frame_map(const FrameMap& map, const std::string& description);

}  // namespace procam::report
