#pragma once
/// Threads that stay for many loops, so that a frame starts none and allocates nothing.
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "procam/core/base/export.hpp"

namespace procam::render {

class PROCAM_EXPORT Workers {
 public:
  /// `threads`, the caller's included; 0: as many as the machine has.
  explicit Workers(int threads);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  /// Calls turn(i) once for every i in [0, count), in any order, and returns when all are done. The first
  /// exception of a turn is rethrown here; turns not yet begun are skipped then.
  template <typename Turn>
  void run(int count, const Turn& turn) {
    run({count, &turn, [](const void* what, int i) { (*static_cast<const Turn*>(what))(i); }});
  }

 private:
  struct Loop {
    int count = 0;
    const void* turn = nullptr;
    void (*call)(const void*, int) = nullptr;
  };
  void run(const Loop& loop);
  void take_turns(std::unique_lock<std::mutex>& lock);
  void serve();

  std::mutex mutex_;
  std::condition_variable begun_, ended_;
  Loop loop_;
  int next_ = 0;                    ///< the turn to take next
  std::atomic<int> working_{0};     ///< threads in a turn
  std::atomic<unsigned> calls_{0};  ///< of the others
  bool leaving_ = false;
  std::exception_ptr failure_;
  std::vector<std::thread> others_;
};

}  // namespace procam::render
