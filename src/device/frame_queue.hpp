#pragma once
/// Between the thread that listens to a camera and the one that asks for frames.
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <utility>

#include "procam/device/frame_source.hpp"

namespace procam::device::internal {

/// Of SeenFrame or SeenDepth.
template <typename Frame>
class NewestFrames {
 public:
  void push(Frame frame) {
    const std::lock_guard<std::mutex> lock(mutex_);
    frames_.push_back(std::move(frame));
    if (frames_.size() > FrameSource::kNewest) frames_.pop_front();
    arrived_.notify_one();
  }
  /// No more frames will come; told to the one who asks for them, after those at hand.
  void fail(const std::exception_ptr& error) {
    const std::lock_guard<std::mutex> lock(mutex_);
    error_ = error;
    arrived_.notify_one();
  }
  std::optional<Frame> next(double after_s, double timeout_s) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout_s);
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      while (!frames_.empty() && !(frames_.front().time_s > after_s)) frames_.pop_front();
      if (!frames_.empty()) {
        Frame frame = std::move(frames_.front());
        frames_.pop_front();
        return frame;
      }
      if (error_) std::rethrow_exception(error_);
      if (arrived_.wait_until(lock, deadline) == std::cv_status::timeout && frames_.empty() && !error_)
        return std::nullopt;
    }
  }

 private:
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::deque<Frame> frames_;
  std::exception_ptr error_;
};

using FrameQueue = NewestFrames<SeenFrame>;

}  // namespace procam::device::internal
