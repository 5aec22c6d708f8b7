#pragma once
#include <string>

#include "group_limits.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/dds/group.hpp"

namespace procam::dds::internal {

/// Throws Error(kInput) for options that no group can have.
inline void require_group(const GroupOptions& options) {
  const std::string& name = options.name;
  const char* const letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
  if (name.empty() || name.size() > 64 || name.find_first_not_of(letters) != name.npos)
    throw Error(ErrorKind::kInput, "group '" + name + "'", "it is no name of a group",
                "give 1 to 64 letters of a-z, A-Z, 0-9, _ and -");
  if (options.strength < -1000 || options.strength > 1000)
    throw Error(ErrorKind::kInput, "group strength " + std::to_string(options.strength),
                "it is not from -1000 to 1000", "give a whole number, e.g. 10");
  if (options.projectors.size() > limits::kGroupProjectors)
    throw Error(ErrorKind::kInput, "group '" + name + "'",
                "a member has at most " + std::to_string(limits::kGroupProjectors) + " projectors",
                "start another process for the others");
  for (const std::string& projector : options.projectors)
    if (projector.size() > limits::kFrameNameBytes)
      throw Error(ErrorKind::kInput, "projector '" + projector + "'",
                  "a name in a group has at most " + std::to_string(limits::kFrameNameBytes) + " bytes",
                  "give it a shorter name in the rig file");
}

}  // namespace procam::dds::internal
