#pragma once
/// Shares a range of rows, frames or views out over threads. Whoever includes it links Threads::Threads.
#include <algorithm>
#include <atomic>
#include <exception>
#include <system_error>
#include <thread>
#include <vector>

#include "procam/core/base/limits.hpp"

namespace procam {

/// Threads to start: `threads`, or the machine's cores for 0; at most limits::kThreads.
inline int thread_count(int threads) {
  if (threads <= 0) threads = int(std::max(1u, std::thread::hardware_concurrency()));
  return std::min(threads, limits::kThreads);
}

namespace internal {

/// Starts `count` threads that call `serve`, or as many as the system grants: the work is shared by those that there
/// are, and by the caller.
template <typename Serve>
void start_threads(std::vector<std::thread>& threads, int count, const Serve& serve) {
  threads.reserve(threads.size() + std::size_t(std::max(count, 0)));
  for (int i = 0; i < count; ++i) {
    try {
      threads.emplace_back(serve);
    } catch (const std::system_error&) {
      return;
    }
  }
}

}  // namespace internal

/// Calls work(i) once for each i of [0, count), started in ascending order, at most `threads` (0: the machine's)
/// at a time. All are called even when one throws; the exception of the lowest i is thrown again here.
template <typename Work>
void parallel_each(int count, int threads, const Work& work) {
  std::vector<std::exception_ptr> errors(std::size_t(std::max(count, 0)));
  std::atomic<int> next{0};
  const auto serve = [&] {
    for (int i = next++; i < count; i = next++) {
      try {
        work(i);
      } catch (...) {
        errors[std::size_t(i)] = std::current_exception();
      }
    }
  };
  std::vector<std::thread> others;
  internal::start_threads(others, std::min(thread_count(threads), count) - 1, serve);
  serve();
  for (std::thread& other : others) other.join();
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
}

/// Calls work(begin, end) on consecutive parts of [0, count), at most `threads` (0: the machine's) at a time,
/// several parts a thread, so that a slow part does not hold up the others. Exceptions as of parallel_each().
template <typename Work>
void parallel_for(int count, int threads, const Work& work) {
  constexpr int kPartsAThread = 8;
  const int members = std::min(thread_count(threads), count);
  if (members <= 1) {
    work(0, count);
    return;
  }
  const int parts = std::min(members * kPartsAThread, count);
  parallel_each(parts, members, [&](int part) {
    work(int(long(count) * part / parts), int(long(count) * (part + 1) / parts));
  });
}

}  // namespace procam
