#pragma once
/// From what the captures show to the cause that is named.
#include <functional>
#include <string>

#include "procam/pattern/gray_code.hpp"
#include "procam/pattern/sequence_check.hpp"
#include "sequence.hpp"

namespace procam::pattern::internal {

/// For people, of a capture's index.
using FrameName = std::function<std::string(int)>;

/// The strongest cause first; nothing that comes after it is known then. `gray_code`: null for other
/// patterns.
void find_cause(Sequence& sequence, const GrayCode* gray_code, const FrameName& name, SequenceCheck& check);

/// "overexposed" where the paper is at full scale.
bool warn_if_overexposed(const Sequence& sequence, SequenceCheck& check);

/// Of a pair that shows the same light on the print, flat light and a projected board: pair 0 of the
/// sequence, by white.
void find_cause_of_pair(const Sequence& sequence, SequenceCheck& check);

std::string stale_message(const FrameName& name, int capture, int shows);

}  // namespace procam::pattern::internal
