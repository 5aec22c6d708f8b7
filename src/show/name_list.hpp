#pragma once
#include <string>
#include <vector>

namespace procam::show {

/// For messages: "left and right".
inline std::string joined(const std::vector<std::string>& names, const char* between = " and ") {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : between) + name;
  return text;
}

}  // namespace procam::show
