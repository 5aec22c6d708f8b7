#pragma once
#include <algorithm>
#include <filesystem>
#include <string>

namespace procam::io {

/// ".PFM" -> ".pfm".
inline std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return char(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); });
  return extension;
}

}  // namespace procam::io
