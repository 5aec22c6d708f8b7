#include "workers.hpp"

#include <algorithm>
#include <utility>

namespace procam::render {

Workers::Workers(int threads) {
  if (threads <= 0) threads = int(std::max(1u, std::thread::hardware_concurrency()));
  for (int i = 1; i < threads; ++i) others_.emplace_back([this] { serve(); });
}

Workers::~Workers() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    leaving_ = true;
  }
  begun_.notify_all();
  for (std::thread& other : others_) other.join();
}

void Workers::run(const Loop& loop) {
  std::unique_lock<std::mutex> lock(mutex_);
  loop_ = loop;
  next_ = 0;
  if (loop.count > 1) begun_.notify_all();
  take_turns(lock);
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
    begun_.wait(lock, [this] { return leaving_ || next_ < loop_.count; });
    if (leaving_) return;
    take_turns(lock);
  }
}

}  // namespace procam::render
