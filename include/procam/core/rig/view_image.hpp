#pragma once
/// An image of a view, reduced: what a report shows of the captures.
#include <string>

#include "procam/core/base/image.hpp"

namespace procam {

/// One camera's image of one view of a session.
struct ViewImage {
  std::string view;    ///< View::name
  std::string camera;  ///< Device::name
  ImageU8 image;       ///< grey
  int scale = 1;       ///< camera pixels a pixel of it: x_camera = scale (x + 1/2) - 1/2
  ImageF decoded =
      {};  ///< of its size, two channels: projector x and y of the light there; -1: not decoded. Empty: no such pattern
};

}  // namespace procam
