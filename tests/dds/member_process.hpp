#pragma once
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>

namespace procam::test {

/// A member of a group or fleet in a process of its own, which ends with the test. To be made before DDS is used here.
class MemberProcess {
 public:
  explicit MemberProcess(const std::function<void()>& member) {
    process_ = fork();
    if (process_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    member();
    _exit(0);
  }
  ~MemberProcess() { end(); }
  void end() {
    if (process_ <= 0) return;
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
    process_ = 0;
  }

 private:
  pid_t process_ = 0;
};

}  // namespace procam::test
