#pragma once
/// The disc of a point that is out of focus.
#include "procam/simulate/thin_lens.hpp"

namespace procam::simulate {

/// The disc's diameter, pixels of the device (a camera, or a projector's inverse camera); depth > 0.
double blur_disc(const ThinLens& lens, const Camera& device, double depth);

}  // namespace procam::simulate
