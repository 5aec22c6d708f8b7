#pragma once
/// The queue between a source's thread and the thread that polls; it keeps the newest messages.
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/track/pose_source.hpp"

namespace procam::track::internal {

template <typename Message>
class InboxOf {
 public:
  explicit InboxOf(const SourceOptions& options) : ring_(options.queue) {
    require(options.queue > 0, "SourceOptions: the queue must hold at least one message");
  }

  /// The result of parsing `bytes` bytes that arrived at `arrival`; `messages` is a member of `parsed`. Both are
  /// moved from.
  template <typename Parsed>
  void put(Parsed& parsed, std::vector<Message>& messages, double arrival, std::size_t bytes) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      status_.bytes += bytes;
      status_.malformed += parsed.malformed;
      if (!parsed.why.empty()) status_.last_error = std::move(parsed.why);
      for (Message& message : messages) {
        message.arrival = arrival;
        keep(std::move(message));
      }
    }
    filled_.notify_all();
  }
  void put(Message&& message) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      keep(std::move(message));
    }
    filled_.notify_all();
  }
  void refuse(const std::string& why) {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++status_.malformed;
    status_.last_error = why;
  }
  void poll(std::vector<Message>& arrived) {
    const std::lock_guard<std::mutex> lock(mutex_);
    arrived.resize(count_);
    // Swapped: both sides keep the memory of their texts.
    for (std::size_t i = 0; i < count_; ++i) std::swap(arrived[i], ring_[(first_ + i) % ring_.size()]);
    count_ = 0;
  }
  /// Until there is a message to poll, at most `seconds`.
  void wait(double seconds) {
    std::unique_lock<std::mutex> lock(mutex_);
    filled_.wait_for(lock, std::chrono::duration<double>(seconds > 0 ? std::min(seconds, kLongestWait) : 0),
                     [this] { return count_ > 0; });
  }

  SourceStatus status() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return status_;
  }
  /// A peer came or went; the last one that goes says why.
  void connected() {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++peers_;
    ++status_.connections;
    status_.connected = true;
  }
  void disconnected(const std::string& why) {
    const std::lock_guard<std::mutex> lock(mutex_);
    --peers_;
    status_.connected = peers_ > 0;
    status_.last_error = why;
  }
  void failed(const std::string& why) {
    const std::lock_guard<std::mutex> lock(mutex_);
    status_.last_error = why;
  }

 private:
  static constexpr double kLongestWait = 3600;  // a clock cannot hold any number

  void keep(Message&& message) {
    ++status_.messages;
    if (count_ == ring_.size()) {
      first_ = (first_ + 1) % ring_.size();
      --count_;
      ++status_.dropped;
    }
    ring_[(first_ + count_++) % ring_.size()] = std::move(message);
  }

  mutable std::mutex mutex_;
  std::condition_variable filled_;
  std::vector<Message> ring_;
  std::size_t first_ = 0, count_ = 0;
  SourceStatus status_;
  int peers_ = 0;
};
using Inbox = InboxOf<StampedPose>;

}  // namespace procam::track::internal
