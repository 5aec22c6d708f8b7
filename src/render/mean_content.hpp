#pragma once
/// The content's mean over one pixel, for pixels that are drawn one by one.
#include <Eigen/Core>

#include "footprint.hpp"
#include "texture.hpp"

namespace procam::render {

using Rgba = Eigen::Array4f;  ///< 0..1, premultiplied by the alpha in the last place

/// `area`: over the footprint; else at its centre.
Rgba mean_content(const LightTexture& texture, const Kernels& kernels, const Footprint& footprint, bool area);
Rgba mean_content(const ValueTexture& texture, const Kernels& kernels, const Footprint& footprint, bool area);

}  // namespace procam::render
