#pragma once
#include <filesystem>
#include <string>

namespace procam::session {

/// "captures" of "data/captures" and of "data/captures/".
inline std::string folder_name(const std::filesystem::path& folder) {
  return (folder.filename().empty() ? folder.parent_path() : folder).filename().string();
}

}  // namespace procam::session
