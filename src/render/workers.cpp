#include "workers.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "procam/core/base/parallel.hpp"

namespace procam::render {

namespace {

/// Returns once it is done, or after a moment: going to sleep and being woken takes as long.
template <typename Done>
void stay_awake_until(const Done& done) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(100);
  while (!done() && std::chrono::steady_clock::now() < end) std::this_thread::yield();
}

}  // namespace

Workers::Workers(int threads) {
  procam::internal::start_threads(others_, thread_count(threads) - 1, [this] { serve(); });
}

Workers::~Workers() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    leaving_ = true;
    ++calls_;
  }
  begun_.notify_all();
  for (std::thread& other : others_) other.join();
}

void Workers::run(const Loop& loop) {
  std::unique_lock<std::mutex> lock(mutex_);
  loop_ = loop;
  next_ = 0;
  if (loop.count > 1) {
    ++calls_;
    begun_.notify_all();
  }
  take_turns(lock);
  lock.unlock();
  stay_awake_until([this] { return working_ == 0; });
  lock.lock();
  ended_.wait(lock, [this] { return working_ == 0; });
  loop_ = {};
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void Workers::take_turns(std::unique_lock<std::mutex>& lock) {
  ++working_;
  while (next_ < loop_.count) {
    const int i = next_++;
    lock.unlock();
    std::exception_ptr failure;
    try {
      loop_.call(loop_.turn, i);
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    if (failure) {
      next_ = loop_.count;
      if (!failure_) failure_ = failure;
    }
  }
  if (--working_ == 0) ended_.notify_all();
}

void Workers::serve() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    const unsigned seen = calls_;
    if (!leaving_ && next_ >= loop_.count) {
      lock.unlock();
      stay_awake_until([&] { return calls_ != seen; });
      lock.lock();
    }
    begun_.wait(lock, [this] { return leaving_ || next_ < loop_.count; });
    if (leaving_) return;
    take_turns(lock);
  }
}

}  // namespace procam::render
