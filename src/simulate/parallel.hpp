#pragma once
/// Shares a range of rows or frames out over threads.
#include <algorithm>
#include <exception>
#include <thread>
#include <vector>

namespace procam::simulate::internal {

/// Calls work(begin, end) on consecutive parts of [0, count), at most `threads` (0: the machine's) at a time.
/// The first part's exception is thrown again here.
template <typename Work>
void parallel_for(int count, int threads, const Work& work) {
  const int wanted = threads > 0 ? threads : int(std::max(1u, std::thread::hardware_concurrency()));
  const int parts = std::min(wanted, count);
  if (parts <= 1) {
    work(0, count);
    return;
  }
  std::vector<std::exception_ptr> errors(static_cast<std::size_t>(parts));
  std::vector<std::thread> team;
  for (int part = 0; part < parts; ++part)
    team.emplace_back([&, part] {
      try {
        work(int(long(count) * part / parts), int(long(count) * (part + 1) / parts));
      } catch (...) {
        errors[std::size_t(part)] = std::current_exception();
      }
    });
  for (std::thread& member : team) member.join();
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
}

}  // namespace procam::simulate::internal
