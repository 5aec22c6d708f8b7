#include "identical_files.hpp"

#include <filesystem>
#include <map>
#include <utility>

namespace procam::session {

void warn_of_identical_files(const std::vector<InputFile>& inputs, Diagnostics& diagnostics) {
  std::map<std::string, std::string> first;                    // the first file of a content, by SHA-256
  std::map<std::pair<std::string, std::string>, int> by_pair;  // folder and the folder that it repeats
  for (const InputFile& input : inputs) {
    const auto [known, is_new] = first.emplace(input.sha256, input.path);
    if (is_new) continue;
    const auto place = [](const std::string& name) {
      const std::string folder = std::filesystem::path(name).parent_path().generic_string();
      return folder.empty() ? name : folder;
    };
    // Within one folder frames may be alike: a pattern shown twice, seen without noise.
    if (place(input.path) != place(known->second)) ++by_pair[{place(input.path), place(known->second)}];
  }
  for (const auto& [pair, count] : by_pair)
    diagnostics.warn(
        "identical_files",
        pair.first + " repeats " + pair.second +
            (count > 1 ? ": " + std::to_string(count) + " files are" : ": it is") +
            " identical, byte by byte; a copy adds no information, capture each pose of the board "
            "once");
}

}  // namespace procam::session
