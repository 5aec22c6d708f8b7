#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "sinks.hpp"

namespace procam::device {
namespace {

class VideoSink : public FrameSink {
 public:
  VideoSink(const std::string& file, const SinkOptions& options) : size_(options.size), file_(file) {
    const std::string extension = std::filesystem::path(file).extension().string();
    int codec = 0;
    if (extension == ".mp4") codec = cv::VideoWriter::fourcc('m', 'p', '4', 'v');
    if (extension == ".mkv") codec = cv::VideoWriter::fourcc('F', 'F', 'V', '1');  // without loss
    if (extension == ".avi") codec = cv::VideoWriter::fourcc('M', 'J', 'P', 'G');
    if (codec == 0)
      throw Error(ErrorKind::kUnsupported, file, "its name tells no kind of video",
                  "name it .mp4, .mkv or .avi");
    if (!std::filesystem::is_directory(std::filesystem::absolute(file).parent_path()))
      throw Error(ErrorKind::kIo, file, "its folder does not exist", "make it first");
    // Whole or not at all under its name: a player cannot read an mp4 whose end was not written.
    partial_ = std::filesystem::path(file).replace_extension(".partial" + extension).string();
    try {
      writer_.open(partial_, codec, options.fps, cv::Size(size_.width, size_.height));
    } catch (const cv::Exception&) {
    }
    if (!writer_.isOpened()) {
      discard();
      throw Error(ErrorKind::kIo, file, "OpenCV's videoio cannot write this video",
                  "try .avi, or sizes and a rate that the codec takes");
    }
  }
  ~VideoSink() override {
    writer_.release();
    std::error_code ignored;
    if (frames_ > 0)
      std::filesystem::rename(partial_, file_, ignored);
    else
      discard();
  }
  VideoSink(const VideoSink&) = delete;
  VideoSink& operator=(const VideoSink&) = delete;

  ImageSize size() const override { return size_; }
  double show(ViewU8 picture) override {
    internal::require_frame(picture, size_);
    const cv::Mat rgb(picture.height, picture.width, picture.channels == 3 ? CV_8UC3 : CV_8UC1,
                      const_cast<std::uint8_t*>(picture.data), std::size_t(picture.stride));
    cv::cvtColor(rgb, bgr_, picture.channels == 3 ? cv::COLOR_RGB2BGR : cv::COLOR_GRAY2BGR);
    writer_.write(bgr_);
    ++frames_;
    return now_s();
  }

 private:
  void discard() {
    std::error_code ignored;
    std::filesystem::remove(partial_, ignored);
  }

  ImageSize size_;
  std::string file_, partial_;
  cv::VideoWriter writer_;
  cv::Mat bgr_;
  long long frames_ = 0;
};

}  // namespace

std::unique_ptr<FrameSink> internal::open_video(const std::string& file, const SinkOptions& options) {
  return std::make_unique<VideoSink>(file, options);
}

}  // namespace procam::device
