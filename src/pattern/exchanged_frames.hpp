#pragma once
/// Captures of Gray code that were exchanged: every bit can be read, and the codes are those of other stripes.
#include <optional>
#include <vector>

#include "procam/pattern/gray_code.hpp"

namespace procam::pattern::internal {

struct ExchangedFrames {
  int first = 0, second = 0;  ///< indices of captures
  bool pairs = false;         ///< with their inverses, which come after them
};

/// Neighbouring pixels see neighbouring stripes, wherever the light falls on one surface:
///
///   T = sum |c(p) - c(q)|   over neighbours p, q, in stripes
///
/// is the extent of the frame in the camera's lines. A pattern taken for its inverse mirrors the codes in blocks, and two
/// bits that were exchanged scatter them: T becomes twice as much or more. The exchange that makes T least is the cause if it
/// makes T far less. Unknown for the coarsest bit's pattern and inverse: these mirror the whole frame.
std::optional<ExchangedFrames> find_exchanged_frames(const std::vector<ViewU8>& captures,
                                                     const GrayCode& gray_code);

}  // namespace procam::pattern::internal
