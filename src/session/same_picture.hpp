#pragma once
/// Pictures that a screen shows: kept, and compared pixel by pixel.
#include <algorithm>

#include "procam/core/base/image.hpp"

namespace procam::session {

inline ImageU8 copy_of(ViewU8 picture) {
  ImageU8 copy(picture.size(), picture.channels);
  for (int y = 0; y < picture.height; ++y)
    std::copy_n(picture.row(y), std::size_t(picture.width) * std::size_t(picture.channels), copy.row(y));
  return copy;
}

inline bool same_picture(ViewU8 a, const ImageU8& b) {
  if (a.size() != b.size() || a.channels != b.channels()) return false;
  for (int y = 0; y < a.height; ++y)
    if (!std::equal(a.row(y), a.row(y) + std::size_t(a.width) * std::size_t(a.channels), b.row(y)))
      return false;
  return true;
}

}  // namespace procam::session
