#pragma once
/// The listener of a run for callers that gave none.
#include "procam/show/run.hpp"

namespace procam::show {

inline ShowListener& listener_or_none(ShowListener* listener) {
  static ShowListener none;
  return listener != nullptr ? *listener : none;
}

}  // namespace procam::show
