#pragma once
/// What a source rejected by its cause ("ros2_invalid_image"), also when it was opened again since.
#include <cstdint>
#include <map>
#include <mutex>
#include <string>

namespace procam::show {

using Rejected = std::map<std::string, std::uint64_t>;

inline void add_to(Rejected& sum, const Rejected& more) {
  for (const auto& [cause, count] : more) sum[cause] += count;
}

/// The thread that reads the source notes its counts; any thread asks.
class RejectedCounts {
 public:
  /// The counts of the source that is open.
  void note(Rejected now) {
    const std::lock_guard<std::mutex> lock(mutex_);
    now_ = std::move(now);
  }
  /// The next counts are those of another one.
  void closed() {
    const std::lock_guard<std::mutex> lock(mutex_);
    add_to(before_, now_);
    now_.clear();
  }
  Rejected counts() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    Rejected sum = before_;
    add_to(sum, now_);
    return sum;
  }

 private:
  mutable std::mutex mutex_;
  Rejected before_, now_;
};

}  // namespace procam::show
