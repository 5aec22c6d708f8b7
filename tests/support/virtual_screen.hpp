#pragma once
/// An X server without a screen (Xvfb), for tests of real windows.
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

namespace procam::test {

/// A server of its own for the time of the object. Not running when Xvfb is not installed, or does not start.
class VirtualScreen {
 public:
  explicit VirtualScreen(const std::string& size) {
    int answer[2];
    if (pipe(answer) != 0) return;
    process_ = fork();
    if (process_ == 0) {
      close(answer[0]);
      const std::string descriptor = std::to_string(answer[1]), screen = size + "x24";
      // It must not outlive a test that crashes, nor keep the pipe of its output open.
      prctl(PR_SET_PDEATHSIG, SIGTERM);
      if (std::freopen("/dev/null", "w", stderr) == nullptr ||
          std::freopen("/dev/null", "w", stdout) == nullptr)
        _exit(127);
      // -noreset: a server that resets when its last client leaves may close the connection of the next one.
      execlp("Xvfb", "Xvfb", "-displayfd", descriptor.c_str(), "-screen", "0", screen.c_str(), "-nolisten",
             "tcp", "-noreset", static_cast<char*>(nullptr));
      _exit(127);
    }
    close(answer[1]);
    // The number of the display that was free, and a newline; nothing when the server ends first.
    char byte = 0;
    while (read(answer[0], &byte, 1) == 1 && byte != '\n') name_ += byte;
    close(answer[0]);
    if (!name_.empty()) name_ = ":" + name_;
  }
  ~VirtualScreen() {
    if (process_ <= 0) return;
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
  }
  VirtualScreen(const VirtualScreen&) = delete;
  VirtualScreen& operator=(const VirtualScreen&) = delete;

  bool is_running() const { return !name_.empty(); }
  /// As DISPLAY names it.
  const std::string& name() const { return name_; }

 private:
  pid_t process_ = -1;
  std::string name_;
};

}  // namespace procam::test
