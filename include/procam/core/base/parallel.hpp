#pragma once
/// Shares a range of rows or frames out over threads. Whoever includes it links Threads::Threads.
#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>
#include <vector>

namespace procam {

/// Calls work(begin, end) on consecutive parts of [0, count), at most `threads` (0: the machine's) at a time,
/// several parts a thread: what is slow in one place holds nobody up. The first part's exception is thrown
/// again here.
template <typename Work>
void parallel_for(int count, int threads, const Work& work) {
  constexpr int kPartsAThread = 8;
  const int wanted = threads > 0 ? threads : int(std::max(1u, std::thread::hardware_concurrency()));
  const int members = std::min(wanted, count);
  if (members <= 1) {
    work(0, count);
    return;
  }
  const int parts = std::min(members * kPartsAThread, count);
  std::vector<std::exception_ptr> errors(static_cast<std::size_t>(parts));
  std::atomic<int> next{0};
  std::vector<std::thread> team;
  for (int member = 0; member < members; ++member)
    team.emplace_back([&] {
      for (int part = next++; part < parts; part = next++) {
        try {
          work(int(long(count) * part / parts), int(long(count) * (part + 1) / parts));
        } catch (...) {
          errors[std::size_t(part)] = std::current_exception();
        }
      }
    });
  for (std::thread& member : team) member.join();
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
}

}  // namespace procam
