#include "procam/device/video_file.hpp"

#include <unistd.h>

#include <algorithm>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/videoio.hpp>

namespace procam::device {

namespace fs = std::filesystem;

namespace {

struct Codec {
  const char* extension;
  int fourcc;
  int api;
};
const Codec kCodecs[] = {
    {".mkv", cv::VideoWriter::fourcc('F', 'F', 'V', '1'), cv::CAP_FFMPEG},
    {".mp4", cv::VideoWriter::fourcc('m', 'p', '4', 'v'), cv::CAP_FFMPEG},
    {".avi", cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), cv::CAP_OPENCV_MJPEG},
};

const Codec& codec_of(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return char(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); });
  for (const Codec& codec : kCodecs)
    if (extension == codec.extension) return codec;
  throw Error(ErrorKind::kUnsupported, path.string(), "no video has this extension",
              "name it .mp4, .mkv or .avi");
}

}  // namespace

class VideoFile::Writer {
 public:
  Writer(fs::path path, ImageSize size, double rate_hz) : path_(std::move(path)) {
    require(size.width > 0 && size.height > 0 && rate_hz >= 1e-3 && rate_hz <= 1e3,
            "VideoFile: the size is empty or the rate not between 0.001 and 1000");
    const Codec& codec = codec_of(path_);
    if (std::string(codec.extension) == ".mp4" && (size.width % 2 != 0 || size.height % 2 != 0))
      throw Error(ErrorKind::kUnsupported, path_.string(),
                  "an .mp4 has an even width and height, not " + std::to_string(size.width) + "x" +
                      std::to_string(size.height),
                  "write an .mkv");
    // Beside the file, with its extension last: the encoder goes by it.
    temporary_ = path_;
    temporary_.replace_filename("." + path_.stem().string() + "." + std::to_string(getpid()) +
                                codec.extension);
    std::error_code error;
    const fs::path folder = path_.has_parent_path() ? path_.parent_path() : fs::path(".");
    if (!fs::is_directory(folder, error) || fs::is_directory(path_, error))
      throw Error(ErrorKind::kIo, path_.string(), "there is no such folder to write it into, or it is one",
                  "name a file in a folder that exists");
    const auto level = cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    try {
      video_.open(temporary_.string(), codec.api, codec.fourcc, rate_hz, {size.width, size.height});
    } catch (const cv::Exception&) {
      video_.release();
    }
    cv::utils::logging::setLogLevel(level);
    if (!video_.isOpened()) {
      fs::remove(temporary_, error);
      throw Error(ErrorKind::kIo, path_.string(), "OpenCV cannot write a video of this kind there",
                  "check the folder, or try another extension: .mp4, .mkv, .avi");
    }
    picture_.create(size.height, size.width, CV_8UC3);
  }
  ~Writer() {
    video_.release();
    std::error_code ignored;
    fs::remove(temporary_, ignored);
  }

  void add(ViewU8 picture) {
    require(picture.width == picture_.cols && picture.height == picture_.rows && picture.channels == 3,
            "VideoFile: the picture has not the file's size, or not 3 channels");
    for (int y = 0; y < picture.height; ++y) {
      const std::uint8_t* from = picture.row(y);
      std::uint8_t* to = picture_.ptr<std::uint8_t>(y);
      for (int x = 0; x < picture.width; ++x, from += 3, to += 3) {
        to[0] = from[2];
        to[1] = from[1];
        to[2] = from[0];
      }
    }
    video_.write(picture_);
  }
  void finish() {
    video_.release();
    std::error_code error;
    if (fs::file_size(temporary_, error) == 0 || error)
      throw Error(ErrorKind::kIo, path_.string(), "nothing was written", "check the room on the disk");
    fs::rename(temporary_, path_, error);
    if (error)
      throw Error(ErrorKind::kIo, path_.string(), "it cannot be put in its place: " + error.message(),
                  "check the folder");
  }

 private:
  fs::path path_, temporary_;
  cv::VideoWriter video_;
  cv::Mat picture_;
};

VideoFile::VideoFile(const fs::path& path, ImageSize size, double rate_hz)
    : writer_(std::make_unique<Writer>(path, size, rate_hz)) {}
VideoFile::~VideoFile() = default;
VideoFile::VideoFile(VideoFile&&) noexcept = default;
VideoFile& VideoFile::operator=(VideoFile&&) noexcept = default;

void VideoFile::add(ViewU8 picture) {
  writer_->add(picture);
}
void VideoFile::finish() {
  writer_->finish();
}

}  // namespace procam::device
