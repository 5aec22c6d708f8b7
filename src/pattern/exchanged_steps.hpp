#pragma once
/// Captures of phase steps that were exchanged.
#include <utility>
#include <vector>

#include "waves.hpp"

namespace procam::pattern::internal {

/// The steps of a wave lie on a cosine, I_k = A + B cos(phi - phi_k), wherever the light falls. With four steps or more there is
/// a residual; over pixels p and waves w
///
///   T = sum_w  sum_p |I - fit|^2 / sum_p |I - mean I|^2.
///
/// Two captures in each other's place raise it. The exchange that makes T least is the cause if it makes T far less: a tone
/// curve, flicker or a moving camera leave T as it is whatever is exchanged. Indices of captures; several where they fit alike,
/// as two pairs of four steps do; none where nothing was exchanged, or with three steps, or where a wave was mirrored (the first
/// and the third of four steps).
std::vector<std::pair<int, int>> find_exchanged_steps(const std::vector<ViewU8>& captures,
                                                      const std::vector<AxisWaves>& axes,
                                                      const PhaseOptions& options);

}  // namespace procam::pattern::internal
