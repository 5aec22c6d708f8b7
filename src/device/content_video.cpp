#include <opencv2/core.hpp>

#include "content_files.hpp"
#include "live_pictures.hpp"
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

/// A camera by OpenCV.
class VideoPictures : public LivePictures {
 public:
  explicit VideoPictures(std::string name) : name_(std::move(name)), video_(open_capture(name_)) {
    if (!video_.isOpened()) throw gone("it cannot be opened");
  }
  bool next(ImageU8& picture) override {
    try {
      if (!video_.isOpened() || !video_.read(decoded_)) throw gone("no more pictures come from it");
    } catch (const cv::Exception& error) {
      throw gone(error.what());
    }
    if (!to_content(decoded_, picture)) throw gone("its pictures are neither grey nor colour of 8 bits");
    return true;
  }
  void reopen() override { video_ = open_capture(name_); }
  Error none() const override { return gone("no picture comes from it"); }

 private:
  Error gone(const std::string& why) const {
    return Error(ErrorKind::kDevice, "camera " + name_, why,
                 "check its number or address, the cable, and that no other program uses it");
  }
  const std::string name_;
  cv::VideoCapture video_;
  cv::Mat decoded_;
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
  return show_live(std::make_unique<VideoPictures>(camera), options);
}

}  // namespace procam::device::internal
