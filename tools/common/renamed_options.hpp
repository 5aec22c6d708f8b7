#pragma once
/// Options that had another name in an earlier version, so that one name has one meaning in all tools. The old spelling is
/// accepted for one version, with a note.
#include <string>
#include <vector>

namespace procam::tools {

struct CurrentArguments {
  std::vector<std::string> arguments;  ///< with today's names, without the program's
  std::vector<std::string> notes;      ///< a sentence for each option that was renamed
};

CurrentArguments with_current_names(const std::string& tool, const std::vector<std::string>& arguments);

}  // namespace procam::tools
