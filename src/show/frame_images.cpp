#include "frame_images.hpp"

#include <chrono>
#include <utility>

#include "procam/core/base/clock.hpp"
#include "procam/core/base/error.hpp"
#include "thread_share.hpp"

namespace procam::show {
namespace {

constexpr double kImagePeriod = 0.2;  // seconds

double unix_time_of(double steady) {
  const double unix_now =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  return unix_now + (steady - steady_now());
}

}  // namespace

FrameImages::FrameImages(dds::ProjectorPublisher& publisher, std::string projector)
    : publisher_(publisher), projector_(std::move(projector)) {
  publisher_.has_image_reader(projector_);  // readers find the topic before the first frame
  thread_ = std::thread([this] { run(); });
}

FrameImages::~FrameImages() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_ending_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void FrameImages::shown(const std::shared_ptr<const ImageU8>& frame, double light_time) {
  const double now = steady_now();
  if (now < sent_ + kImagePeriod) return;
  sent_ = now;
  if (!publisher_.has_image_reader(projector_)) return;
  std::string fault;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    fault = std::exchange(fault_, {});
    if (!next_) {
      next_ = frame;
      next_time_ = unix_time_of(light_time);
    }
  }
  wake_.notify_one();
  if (!fault.empty()) throw Error(ErrorKind::kDevice, "image of the frame", fault, "check the network");
}

void FrameImages::run() {
  let_the_show_go_first();
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    wake_.wait(lock, [&] { return next_ || is_ending_; });
    if (is_ending_) return;
    const std::shared_ptr<const ImageU8> frame = next_;
    const double time = next_time_;
    std::string fault;
    lock.unlock();
    try {
      publisher_.publish_image(projector_, *frame, time);
    } catch (const std::exception& error) {
      fault = error.what();
    }
    lock.lock();
    next_.reset();
    if (!fault.empty()) fault_ = std::move(fault);
  }
}

}  // namespace procam::show
