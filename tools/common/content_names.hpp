#pragma once
/// File names in the texts that name content ("wall.png", "video:clip.bin", "#ff8000"; see
/// device/content_source.hpp).
#include <filesystem>
#include <functional>
#include <string>

namespace procam::tools {

/// The text with its file's name changed; a colour or a camera stays as it is.
inline std::string with_content_file(const std::string& what,
                                     const std::function<std::string(const std::string&)>& change) {
  if (what.empty() || what[0] == '#' || what.find("://") != std::string::npos) return what;
  for (const char* kind : {"color:", "camera:", "shm:"})
    if (what.rfind(kind, 0) == 0) return what;
  for (const std::string kind : {"image:", "images:", "video:"})
    if (what.rfind(kind, 0) == 0) return kind + change(what.substr(kind.size()));
  return change(what);
}

/// Of content that is named beside a file.
inline std::string content_beside(const std::filesystem::path& file, const std::string& what) {
  return with_content_file(what,
                           [&](const std::string& name) { return (file.parent_path() / name).string(); });
}

}  // namespace procam::tools
