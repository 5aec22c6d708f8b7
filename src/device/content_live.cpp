#include <array>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "live_pictures.hpp"

namespace procam::device::internal {
namespace {

/// Three pictures take turns: the caller looks at one, the newest is another, the next comes into the third.
class LiveContent : public ContentSource {
 public:
  LiveContent(std::unique_ptr<LivePictures> pictures, const ContentOptions& options)
      : pictures_(std::move(pictures)), pace_(options.pace) {
    thread_ = std::thread([this] { listen(); });
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait_for(lock, std::chrono::duration<double>(options.camera_patience_s),
                      [this] { return newest_ != nullptr || fault_; });
    if (newest_) return;
    const std::optional<Error> fault = fault_;
    lock.unlock();
    stop();
    throw fault ? *fault : pictures_->none();
  }
  ~LiveContent() override { stop(); }

  ContentFrame at(double) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (pace_ == Pace::kExact && fault_) throw *fault_;
    shown_ = newest_;
    return {shown_->picture.view(), shown_->number};
  }
  std::optional<Error> fault() const override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return fault_;
  }
  std::map<std::string, std::uint64_t> rejected() const override { return pictures_->rejected(); }

 private:
  struct Slot {
    ImageU8 picture;
    std::uint64_t number = 0;
  };
  static constexpr std::chrono::seconds kBetweenTries{1};

  void stop() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

  void listen() {
    std::unique_lock<std::mutex> lock(mutex_);
    std::uint64_t number = 0;
    while (!stop_) {
      Slot* free = nullptr;
      for (Slot& slot : slots_)
        if (&slot != shown_ && &slot != newest_) free = &slot;
      lock.unlock();
      bool is_new = false;
      std::optional<Error> fault;
      try {
        is_new = pictures_->next(free->picture);
        if (is_new) check(free->picture);
      } catch (const Error& error) {
        fault = error;
      }
      lock.lock();
      if (!fault && !is_new) continue;
      fault_ = fault;
      if (!fault) {
        free->number = ++number;
        newest_ = free;
      }
      changed_.notify_all();
      if (!fault) continue;
      if (changed_.wait_for(lock, kBetweenTries, [this] { return stop_; })) break;
      lock.unlock();
      pictures_->reopen();
      lock.lock();
    }
  }

  /// All pictures are as the first one.
  void check(const ImageU8& picture) {
    if (channels_ == 0) {
      size_ = picture.size();
      channels_ = picture.channels();
    }
    if (picture.size() == size_ && picture.channels() == channels_) return;
    const Error why = pictures_->none();
    throw Error(ErrorKind::kDevice, why.subject(),
                "its pictures have become " + std::to_string(picture.width()) + "x" +
                    std::to_string(picture.height()) + " with " + std::to_string(picture.channels()) +
                    " channels",
                "start this program again, or set the source back");
  }

  const std::unique_ptr<LivePictures> pictures_;
  const Pace pace_;
  ImageSize size_{0, 0};  ///< of the first picture; of the thread alone, as the next
  int channels_ = 0;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::array<Slot, 3> slots_;
  Slot *shown_ = nullptr, *newest_ = nullptr;
  std::optional<Error> fault_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace

std::unique_ptr<ContentSource> show_live(std::unique_ptr<LivePictures> pictures,
                                         const ContentOptions& options) {
  return std::make_unique<LiveContent>(std::move(pictures), options);
}

}  // namespace procam::device::internal
