#pragma once
/// Examples of the tools' command lines, as their --help prints them. tests/docs checks every option of them.
#include <string>
#include <vector>

namespace procam::tools {

struct Example {
  std::string purpose;  ///< a few words, printed as a comment
  std::string command;  ///< one line for a shell
};

/// Of one tool, by its program's name, the most usual first; none for an unknown name.
const std::vector<Example>& examples(const std::string& tool);

}  // namespace procam::tools
