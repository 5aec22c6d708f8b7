#pragma once
/// Tools on their way, beside the test.
#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>

#include "tool_runner.hpp"

namespace procam::test {

namespace fs = std::filesystem;

/// A tool by its name, or any program by its absolute path, on its way.
class Running {
 public:
  Running(const std::string& tool, const std::string& arguments, const fs::path& out,
          const std::string& variables = "") {
    process_ = fork();
    if (process_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      const std::string program = tool[0] == '/' ? tool : std::string(PROCAM_TOOLS) + "/" + tool;
      const std::string line = "exec env " + variables + " " + program + " " + arguments + " >" +
                               out.string() + " 2>" + out.string() + ".err </dev/null";
      execl("/bin/sh", "sh", "-c", line.c_str(), static_cast<char*>(nullptr));
      _exit(127);
    }
  }
  ~Running() {
    if (process_ > 0) {
      kill(process_, SIGKILL);
      waitpid(process_, nullptr, 0);
    }
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;
  bool is_running() {
    if (process_ > 0 && waitpid(process_, &status_, WNOHANG) == process_) process_ = -1;
    return process_ > 0;
  }
  int wait() {
    if (process_ > 0) waitpid(process_, &status_, 0);
    process_ = -1;
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
  }
  /// Nobody when it has ended: kill() takes -1 for all processes of the machine.
  void tell(int signal) {
    if (is_running()) kill(process_, signal);
  }
  pid_t process() const { return process_; }
  /// Resident memory of its own, bytes: anonymous and shared. Pages of libraries that a first use brings in are those
  /// of the files, and not counted.
  double memory() const {
    std::ifstream file("/proc/" + std::to_string(process_) + "/status");
    double sum_kib = 0;
    for (std::string line; std::getline(file, line);)
      if (line.rfind("RssAnon:", 0) == 0 || line.rfind("RssShmem:", 0) == 0)
        sum_kib += std::stod(line.substr(line.find(':') + 1));
    return 1024 * sum_kib;
  }

 private:
  pid_t process_ = -1;
  int status_ = 0;
};

}  // namespace procam::test
