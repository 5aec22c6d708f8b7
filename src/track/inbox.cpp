#include "inbox.hpp"

#include <utility>

#include "procam/core/error.hpp"

namespace procam::track::internal {

Inbox::Inbox(const SourceOptions& options) : ring_(options.queue) {
  require(options.queue > 0, "SourceOptions: the queue must hold at least one message");
}

void Inbox::keep(StampedPose&& message) {
  ++status_.messages;
  if (count_ == ring_.size()) {
    first_ = (first_ + 1) % ring_.size();
    --count_;
    ++status_.dropped;
  }
  ring_[(first_ + count_++) % ring_.size()] = std::move(message);
}

void Inbox::put(Parsed&& parsed, double arrival, std::size_t bytes) {
  const std::lock_guard<std::mutex> lock(mutex_);
  status_.bytes += bytes;
  status_.malformed += parsed.malformed;
  if (!parsed.why.empty()) status_.last_error = std::move(parsed.why);
  for (StampedPose& message : parsed.poses) {
    message.arrival = arrival;
    keep(std::move(message));
  }
}
void Inbox::put(StampedPose&& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  keep(std::move(message));
}
void Inbox::refuse(const std::string& why) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++status_.malformed;
  status_.last_error = why;
}

void Inbox::poll(std::vector<StampedPose>& arrived) {
  const std::lock_guard<std::mutex> lock(mutex_);
  arrived.resize(count_);
  // Swapped: both sides keep the memory of their texts.
  for (std::size_t i = 0; i < count_; ++i) std::swap(arrived[i], ring_[(first_ + i) % ring_.size()]);
  count_ = 0;
}

SourceStatus Inbox::status() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return status_;
}
void Inbox::connected() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++peers_;
  ++status_.connections;
  status_.connected = true;
}
void Inbox::disconnected(const std::string& why) {
  const std::lock_guard<std::mutex> lock(mutex_);
  --peers_;
  status_.connected = peers_ > 0;
  status_.last_error = why;
}
void Inbox::failed(const std::string& why) {
  const std::lock_guard<std::mutex> lock(mutex_);
  status_.last_error = why;
}

}  // namespace procam::track::internal
