#pragma once
/// A screen, a simulated camera before it, and capture-session.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <sstream>
#include <string>

#include "small_stage.hpp"
#include "support/virtual_screen.hpp"
#include "tool_runner.hpp"

namespace procam::test {

#ifdef PROCAM_SIMULATED_CAMERA

/// A process of this test; ended with it.
class Process {
 public:
  explicit Process(const std::string& command) {
    process_ = fork();
    if (process_ != 0) return;
    execl("/bin/sh", "sh", "-c", ("exec " + command).c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  ~Process() {
    if (process_ <= 0) return;
    signal(SIGTERM);
    wait();
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void signal(int number) const {
    if (process_ > 0) kill(process_, number);
  }
  bool has_ended() {
    if (process_ > 0 && waitpid(process_, &status_, WNOHANG) == process_) process_ = -1;
    return process_ <= 0;
  }
  /// Its exit code.
  int wait() {
    if (process_ > 0) waitpid(process_, &status_, 0);
    process_ = -1;
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
  }

 private:
  pid_t process_ = -1;
  int status_ = 0;
};

/// Screen, camera and what capture-session is told of them.
class CaptureStage : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!screen_.is_running()) GTEST_SKIP() << "no Xvfb here";
    if (run("--list-displays", "list").exit_code == 6)
      GTEST_SKIP() << "no window can be opened: " << slurp(scratch_ / "list.err");
    std::filesystem::create_directory(scratch_ / "shots");
  }
  /// The command of the simulated camera.
  std::string camera(double delay_ms, double faults, double keystone) const {
    std::ostringstream command;
    command << "env DISPLAY=" << screen_.name() << " " << PROCAM_SIMULATED_CAMERA << " "
            << (scratch_ / "shots").string() << " " << session() << " 40 " << delay_ms << " " << faults << " "
            << keystone << " 11";
    return command.str();
  }
  std::string command(const std::string& arguments, const std::string& log) const {
    return "env DISPLAY=" + screen_.name() + " " + PROCAM_TOOLS + "/capture-session " + arguments + " >" +
           (scratch_ / (log + ".out")).string() + " 2>" + (scratch_ / (log + ".err")).string() +
           " </dev/null";
  }
  ToolRun run(const std::string& arguments, const std::string& log) const {
    const int code = Process(command(arguments, log)).wait();
    return {code, slurp(scratch_ / (log + ".out")), slurp(scratch_ / (log + ".err"))};
  }
  std::string session() const { return (scratch_ / "session").string(); }
  std::string arguments() const {
    return rest_of_arguments("--watch " + (scratch_ / "shots").string(), kStagePoses);
  }
  std::string rest_of_arguments(const std::string& camera, int views) const {
    return "--json " + camera + " --board chessboard:8x5:45mm --views " + std::to_string(views) +
           " --step 4 --interval 150ms -o " + session();
  }

  const VirtualScreen screen_{std::to_string(kStageProjector.width) + "x" +
                              std::to_string(kStageProjector.height)};
  const ScratchFolder scratch_;
};

#endif

}  // namespace procam::test
