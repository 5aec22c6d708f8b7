#include "exchange/archive.hpp"

#include <algorithm>

namespace procam::io {

bool leads_outside(const std::string& member) {
  if (member.empty() || member[0] == '/' || member.find('\\') != std::string::npos ||
      member.find(':') != std::string::npos || member.find('\0') != std::string::npos)
    return true;
  for (std::size_t at = 0; at <= member.size();) {
    const std::size_t end = std::min(member.find('/', at), member.size());
    if (member.compare(at, end - at, "..") == 0) return true;
    at = end + 1;
  }
  return false;
}

}  // namespace procam::io
