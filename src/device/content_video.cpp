#include <array>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <opencv2/core.hpp>
#include <thread>

#include "content_files.hpp"
#include "playback.hpp"
#include "procam/core/base/detail/regular_file.hpp"
#include "video_capture.hpp"

namespace procam::device::internal {

namespace {

constexpr double kHighestRate = 1000;  // pictures a second: what is beyond is a time base, not a rate

class Video : public PictureReader {
 public:
  explicit Video(const std::string& file) : name_(file) { open(); }
  const std::string& name() const override { return name_; }
  double rate_hz() const {
    const double rate = video_.get(cv::CAP_PROP_FPS);
    return rate > 0 && rate <= kHighestRate ? rate : 0;
  }

  bool read(ImageU8& picture) override {
    try {
      if (!video_.read(decoded_)) return false;
    } catch (const cv::Exception& error) {
      throw unreadable(error.what());
    }
    if (!to_content(decoded_, picture))
      throw unreadable("its pictures are neither grey nor colour of 8 bits");
    return true;
  }
  bool skip() override {
    try {
      return video_.grab();
    } catch (const cv::Exception& error) {
      throw unreadable(error.what());
    }
  }
  /// By opening it again: going to a picture by its number is off in many files.
  void rewind() override { open(); }

 private:
  Error unreadable(const std::string& why) const {
    return Error(ErrorKind::kInput, name_, why, "convert it, e.g. to H.264 in an .mp4 file");
  }
  /// Also when it begins anew, so the file may have been removed or replaced. A name without a file would be tried as
  /// a device by all backends of OpenCV, some of which leave memory behind.
  void open() {
    std::error_code ignored;
    if (!std::filesystem::exists(name_, ignored))
      throw Error(ErrorKind::kIo, name_, "there is no such file", "check the name of the video");
    procam::internal::require_regular_file(name_);
    video_ = open_capture(name_);
    if (!video_.isOpened()) throw unreadable("OpenCV cannot open it as a video");
  }

  std::string name_;
  cv::VideoCapture video_;
  cv::Mat decoded_;
};

/// A thread reads the camera; three pictures take turns: the caller looks at one, the newest is another, the
/// next comes into the third.
class LiveCamera : public ContentSource {
 public:
  LiveCamera(std::string name, const ContentOptions& options)
      : name_(std::move(name)), pace_(options.pace), video_(open_capture(name_)) {
    if (!video_.isOpened()) throw gone("it cannot be opened");
    thread_ = std::thread([this] { listen(); });
    std::unique_lock<std::mutex> lock(mutex_);
    const bool any = changed_.wait_for(lock, std::chrono::duration<double>(options.camera_patience_s),
                                       [this] { return newest_ != nullptr || fault_; });
    if (any && newest_) return;
    const Error error = fault_ ? *fault_ : gone("no picture comes from it");
    lock.unlock();
    stop();
    throw error;
  }
  ~LiveCamera() override { stop(); }

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

 private:
  struct Slot {
    ImageU8 picture;
    std::uint64_t number = 0;
  };
  static constexpr std::chrono::seconds kBetweenTries{1};

  Error gone(const std::string& why) const {
    return Error(ErrorKind::kDevice, "camera " + name_, why,
                 "check its number or address, the cable, and that no other program uses it");
  }
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
      const std::string why = next(free->picture);
      lock.lock();
      if (why.empty()) {
        free->number = ++number;
        newest_ = free;
        fault_.reset();
        changed_.notify_all();
        continue;
      }
      fault_ = gone(why);
      changed_.notify_all();
      if (changed_.wait_for(lock, kBetweenTries, [this] { return stop_; })) break;
      lock.unlock();
      video_ = open_capture(name_);
      lock.lock();
    }
  }

  /// Waits for the next picture; else says why there is none.
  std::string next(ImageU8& picture) {
    try {
      if (!video_.isOpened() || !video_.read(decoded_)) return "no more pictures come from it";
    } catch (const cv::Exception& error) {
      return error.what();
    }
    if (size_.width > 0 && (decoded_.cols != size_.width || decoded_.rows != size_.height))
      return "its pictures have become " + std::to_string(decoded_.cols) + "x" +
             std::to_string(decoded_.rows);
    if (!to_content(decoded_, picture)) return "its pictures are neither grey nor colour of 8 bits";
    size_ = picture.size();
    return "";
  }

  const std::string name_;
  const Pace pace_;
  cv::VideoCapture video_;
  cv::Mat decoded_;
  ImageSize size_{0, 0};  ///< of the first picture; of the thread alone
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::array<Slot, 3> slots_;
  Slot *shown_ = nullptr, *newest_ = nullptr;
  std::optional<Error> fault_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace

std::unique_ptr<ContentSource> open_video(const std::string& file, double rate_hz,
                                          const ContentOptions& options) {
  auto video = std::make_unique<Video>(file);
  const double rate = rate_hz > 0 ? rate_hz : video->rate_hz();
  if (!(rate > 0))
    throw Error(ErrorKind::kInput, file, "its header does not tell its pictures a second",
                "write them behind it, e.g. " + file + "@30");
  return play(std::move(video), rate, options);
}

std::unique_ptr<ContentSource> open_live(const std::string& camera, const ContentOptions& options) {
  return std::make_unique<LiveCamera>(camera, options);
}

}  // namespace procam::device::internal
