#pragma once
/// Runs procam's tools as a user does: a command line in, an exit code and text out.
#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

namespace procam::test {

struct ToolRun {
  int exit_code = -1;
  std::string out;  ///< stdout
  std::string err;  ///< stderr

  nlohmann::json json() const { return nlohmann::json::parse(out); }
};

/// A folder of its own, removed at the end.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "procam_e2e_XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

inline std::string slurp(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

/// `program` by path, `arguments` as typed in a shell; `variables` go before the command ("DISPLAY=:1").
inline ToolRun run_program(const std::string& program, const std::string& arguments,
                           const std::string& variables = "") {
  const ScratchFolder logs;
  const std::string command = variables + " " + program + " " + arguments + " >" + (logs / "out").string() +
                              " 2>" + (logs / "err").string() + " </dev/null";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), slurp(logs / "out"),
          slurp(logs / "err")};
}

/// `tool` by name, the rest as above.
inline ToolRun run_tool(const std::string& tool, const std::string& arguments,
                        const std::string& variables = "") {
  return run_program(std::string(PROCAM_TOOLS) + "/" + tool, arguments, variables);
}

}  // namespace procam::test
