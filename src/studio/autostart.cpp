#include "autostart.hpp"

#include "procam/core/base/error.hpp"

namespace procam::studio {
namespace {

namespace fs = std::filesystem;

/// project-live beside the running program; else by its name, which systemd looks for in the usual folders.
std::string show_tool() {
  std::error_code problem;
  const fs::path self = fs::read_symlink("/proc/self/exe", problem);
  const fs::path tool = self.parent_path() / "project-live";
  return !problem && fs::exists(tool, problem) ? tool.string() : "project-live";
}

/// systemd replaces "%": systemd.unit(5), Specifiers.
std::string without_specifiers(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '%' ? "%%" : std::string(1, c);
  return out;
}

/// One word of a command line: systemd.service(5), Command lines.
std::string word(const std::string& text) {
  std::string out = "\"";
  for (const char c : without_specifiers(text)) {
    if (c == '"' || c == '\\') out += '\\';
    out += c == '$' ? "$$" : std::string(1, c);
  }
  return out + "\"";
}

}  // namespace

std::string service_file(const fs::path& project) {
  const std::string folder = fs::absolute(project).lexically_normal().string();
  if (folder.find_first_of("\r\n") != std::string::npos)
    throw Error(ErrorKind::kInput, "the project's folder", "its name has a line break", "rename the folder");
  return "# The show of this folder begins at login and is started again when it ends or hangs.\n"
         "[Unit]\n"
         "Description=procam show\n"
         "Documentation=man:project-live(1)\n"
         "PartOf=graphical-session.target\n"
         "After=graphical-session.target\n"
         "StartLimitIntervalSec=0\n"
         "\n"
         "[Service]\n"
         "Type=notify\n"
         "ExecStart=" +
         word(show_tool()) +
         " --rig rig.json --show show.json --autosave\n"
         "WorkingDirectory=" +
         without_specifiers(folder) +
         "\n"
         "Restart=always\n"
         "RestartSec=100ms\n"
         "TimeoutStartSec=60\n"
         "WatchdogSec=10\n"
         "SuccessExitStatus=130\n"
         "\n"
         "[Install]\n"
         "WantedBy=graphical-session.target\n";
}

}  // namespace procam::studio
