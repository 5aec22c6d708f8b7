#include "procam/device/video_file.hpp"
#include "sinks.hpp"

namespace procam::device {
namespace {

class VideoSink : public FrameSink {
 public:
  VideoSink(const std::string& file, const SinkOptions& options)
      : size_(options.size), file_(file, options.size, options.fps), picture_(options.size, 3) {}
  ImageSize size() const override { return size_; }
  double show(ViewU8 picture) override {
    internal::require_frame(picture, size_);
    internal::copy_rgb(picture, picture_.data());
    file_.add(picture_);
    return now_s();
  }
  void finish() override { file_.finish(); }

 private:
  ImageSize size_;
  VideoFile file_;
  ImageU8 picture_;
};

}  // namespace

std::unique_ptr<FrameSink> internal::open_video(const std::string& file, const SinkOptions& options) {
  return std::make_unique<VideoSink>(file, options);
}

}  // namespace procam::device
