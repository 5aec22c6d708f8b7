#pragma once
/// Outline, holes and mask as alpha.
#include "procam/core/surface/content_layout.hpp"

namespace procam::surface {

/// Over the content coordinates from `from` to `to`, of `size` pixels.
ImageU8 shape_mask(const ContentShape& shape, const Vec2& from, const Vec2& to, ImageSize size);

}  // namespace procam::surface
