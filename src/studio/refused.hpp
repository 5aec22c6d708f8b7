#pragma once
/// The error of a command that the desk does not follow.
#include <string>

#include "procam/core/base/error.hpp"

namespace procam::studio {

inline Error refused(const std::string& what, const std::string& why, const std::string& next) {
  return Error(ErrorKind::kInput, what, why, next);
}

}  // namespace procam::studio
