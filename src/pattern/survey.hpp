#pragma once
/// A sparse check of the captures before any pixel is decoded: are they the frames that were asked
/// for, how noisy are they, what deserves a remark.
#include <vector>

#include "procam/core/base/image.hpp"
#include "procam/core/rig/decoded_map.hpp"
#include "procam/pattern/gray_code.hpp"

namespace procam::pattern {

/// Throws procam::Error naming the frame if number, size or channels of the captures are not the pattern's.
void check_captures(const std::vector<ViewU8>& captures, const GrayCode& gray_code);

struct Survey {
  NoiseModel noise;
  Diagnostics diagnostics;
};

/// Measures the noise on a grid of pixels and checks that white is brighter than black (else procam::Error),
/// that every inverse complements its pattern, and that the exposure is neither saturated nor dark.
Survey survey_captures(const std::vector<ViewU8>& captures, const GrayCode& gray_code, int min_contrast);

/// What came of the pixels.
struct CodeCounts {
  long decoded = 0;          ///< in both axes
  long outside[2] = {0, 0};  ///< readable, but beyond the projector: [columns, rows]
};

/// Remarks on what was decoded: share and range of the codes, stated projector size, exchanged axes.
void remark_on_codes(DecodedMap& map, const GrayCode& gray_code, const CodeCounts& counts);

}  // namespace procam::pattern
