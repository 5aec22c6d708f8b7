#include <algorithm>
#include <atomic>
#include <opencv2/imgproc.hpp>
#include <thread>

#include "camera_kinds.hpp"
#include "frame_queue.hpp"
#include "procam/device/frame_sink.hpp"
#include "video_capture.hpp"

namespace procam::device {
namespace {

Error camera_error(const std::string& name, const std::string& why, const std::string& next) {
  return Error(ErrorKind::kDevice, "camera " + name, why, next);
}

ImageU8 to_grey(const cv::Mat& picture, const std::string& name) {
  cv::Mat grey;
  if (picture.type() == CV_8UC3)
    cv::extractChannel(picture, grey, 1);  // as io::green_channel()
  else if (picture.type() == CV_8UC1)
    grey = picture;
  else
    throw camera_error(name, "its pictures are neither grey nor colour of 8 bits",
                       "choose another mode of the camera");
  ImageU8 image(grey.cols, grey.rows);
  for (int y = 0; y < grey.rows; ++y) std::copy_n(grey.ptr<std::uint8_t>(y), grey.cols, image.row(y));
  return image;
}

class Camera : public FrameSource {
 public:
  Camera(const std::string& name, const CameraOptions& options)
      : name_(name), video_(internal::open_capture(name)) {
    if (!video_.isOpened()) throw camera_error(name, "it cannot be opened", kNext);
    if (options.size) {
      video_.set(cv::CAP_PROP_FRAME_WIDTH, options.size->width);
      video_.set(cv::CAP_PROP_FRAME_HEIGHT, options.size->height);
      const ImageSize got{int(video_.get(cv::CAP_PROP_FRAME_WIDTH)),
                          int(video_.get(cv::CAP_PROP_FRAME_HEIGHT))};
      if (got != *options.size)
        throw camera_error(name,
                           "it does not offer the size asked for, but " + std::to_string(got.width) + "x" +
                               std::to_string(got.height),
                           "ask for a size that it has");
    }
    if (options.exposure) {
      constexpr double kManualOfVideo4Linux = 1;
      video_.set(cv::CAP_PROP_AUTO_EXPOSURE, kManualOfVideo4Linux);
      if (!video_.set(cv::CAP_PROP_EXPOSURE, *options.exposure))
        throw camera_error(name, "its driver does not take an exposure", "set it with the camera's own tool");
    }
    listener_ = std::thread([this] { listen(); });
  }
  ~Camera() override {
    stop_ = true;
    listener_.join();
  }

  std::optional<SeenFrame> next(double after_s, double timeout_s) override {
    return queue_.next(after_s, timeout_s);
  }

 private:
  static constexpr const char* kNext =
      "check its number or address, the cable, and that no other program uses it";

  void listen() {
    try {
      cv::Mat picture;
      while (!stop_) {
        if (!video_.grab() || !video_.retrieve(picture))
          throw camera_error(name_, "no more pictures come from it", kNext);
        const double time = now_s();
        queue_.push({to_grey(picture, name_), time});
      }
    } catch (const cv::Exception& error) {
      queue_.fail(std::make_exception_ptr(camera_error(name_, error.what(), kNext)));
    } catch (...) {
      queue_.fail(std::current_exception());
    }
  }

  std::string name_;
  cv::VideoCapture video_;
  internal::FrameQueue queue_;
  std::atomic<bool> stop_{false};
  std::thread listener_;  // last: it uses all the others
};

}  // namespace

std::unique_ptr<FrameSource> internal::open_video_camera(const std::string& name,
                                                         const CameraOptions& options) {
  return std::make_unique<Camera>(name, options);
}

}  // namespace procam::device
