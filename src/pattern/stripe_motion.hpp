#pragma once
/// Does the projected frame move during a Gray-code sequence?
#include <optional>

#include "procam/pattern/gray_code.hpp"
#include "sequence.hpp"

namespace procam::pattern::internal {

/// Every edge of a coarse bit is in the middle of a finer bit's stripe. When the projected frame moves
/// between the captures of the two, it is not: by the motion between them. The offset of the axis' coarsest
/// bits from the stripes of 16 projector pixels, projector pixels: of two bits the smaller, 0 where they
/// disagree in direction; nullopt where too few edges are seen. Print and response do not matter: at a
/// stripe's edge frame and inverse are equal.
std::optional<double> stripe_motion(const Sequence& sequence, const GrayCode& gray_code, StripeAxis axis);

}  // namespace procam::pattern::internal
