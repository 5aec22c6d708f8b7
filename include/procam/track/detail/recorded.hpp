#pragma once
/// A recorded run as a source of poses or skeletons. It needs no thread: poll() returns the messages that are due.
#include <string>
#include <utility>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/track/pose_source.hpp"

namespace procam::track::internal {

/// "FILE@SPEED" or "FILE"; without a speed it is 1. Throws Error(kInput).
struct FileAndSpeed {
  std::string file;
  double speed = 1;
};
PROCAM_EXPORT FileAndSpeed parse_file_and_speed(const std::string& rest);

template <typename Message, typename Source>
class Recorded : public Source {
 public:
  /// In recorded time from now on, `speed` times as fast; 0: all at once, with the arrivals of then.
  Recorded(std::vector<Message> messages, double speed) : messages_(std::move(messages)), speed_(speed) {
    if (!(speed_ > 0) || messages_.empty()) return;
    const double opened = steady_now(), first = messages_.front().arrival;
    for (Message& message : messages_) message.arrival = opened + (message.arrival - first) / speed_;
  }
  void poll(std::vector<Message>& arrived) override {
    arrived.clear();
    const double now = steady_now();
    for (; next_ < messages_.size() && (speed_ == 0 || messages_[next_].arrival <= now); ++next_)
      arrived.push_back(messages_[next_]);
  }
  SourceStatus status() const override {
    SourceStatus status;
    status.connected = next_ < messages_.size();
    status.messages = next_;
    status.connections = 1;
    return status;
  }

 private:
  std::vector<Message> messages_;
  double speed_;
  std::size_t next_ = 0;
};

}  // namespace procam::track::internal
