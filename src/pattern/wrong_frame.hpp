#pragma once
/// Captures that show another frame than their own, in all rows (stale) or in a part of them (torn).
#include <optional>
#include <vector>

#include "sequence.hpp"

namespace procam::pattern::internal {

struct WrongFrame {
  int capture = 0, shows = 0;  ///< indices of captures
  bool torn = false;
  int pair = 0;
};

/// Of a wrong capture the pair sum misses white and black by the stripes' contrast, and the capture equals
/// its neighbour in time instead:
///
///   sum^2 = mean (S - gain R)^2 / (W - B)^2,   like^2 = mean (L_i - L_j)^2 / (W - B)^2   by band of rows
///
/// A band's sum is wrong when it is far above that of the pairs before and after, so that a board which moved
/// (all pairs before) and noise (all pairs) are no wrong frames. It is explained by frame j when like is far
/// below sum. `gains`: of each pair, nullopt where unknown.
std::optional<WrongFrame> find_wrong_frame(const Sequence& sequence,
                                           const std::vector<std::optional<Sequence::Gain>>& gains);

/// What is wrong with Gray code's last two captures, white and black: nothing can be checked against them
/// then. A missing frame moves all later ones forward, and the last one stands twice.
enum class EndFault { kNone, kNoWhite, kStaleWhite, kStaleBlack };
EndFault end_fault(const Sequence& sequence);

}  // namespace procam::pattern::internal
