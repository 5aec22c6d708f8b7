#include "procam/device/depth_source.hpp"

#include <algorithm>
#include <charconv>
#include <opencv2/videoio.hpp>
#include <opencv2/videoio/registry.hpp>

#include "watched_folder.hpp"

namespace procam::device {
namespace {

namespace fs = std::filesystem;

Error depth_error(const std::string& name, const std::string& why, const std::string& next) {
  return Error(ErrorKind::kDevice, "depth camera " + name, why, next);
}

/// A source whose thread runs `pictures(push, ended)` until that returns or throws.
class Listened : public DepthSource {
 public:
  std::optional<SeenDepth> next(double after_s, double timeout_s) override {
    return queue_.next(after_s, timeout_s);
  }

 protected:
  template <typename Pictures>
  void listen(Pictures pictures) {
    thread_ = std::thread([this, pictures]() mutable {
      try {
        pictures();
      } catch (const cv::Exception& error) {
        queue_.fail(std::make_exception_ptr(depth_error("of OpenCV", error.what(), "check its cable")));
      } catch (...) {
        queue_.fail(std::current_exception());
      }
    });
  }
  void end() {
    ends_ = true;
    if (thread_.joinable()) thread_.join();
  }
  internal::NewestFrames<SeenDepth> queue_;
  std::atomic<bool> ends_{false};

 private:
  std::thread thread_;
};

class Played : public Listened {
 public:
  Played(const std::string& folder, double rate, const ReadDepth& read) {
    std::vector<fs::path> files;
    std::error_code error;
    for (fs::directory_iterator entry(folder, error), last; !error && entry != last; entry.increment(error))
      if (internal::is_picture(entry->path())) files.push_back(entry->path());
    if (error || files.empty())
      throw depth_error("folder:" + folder, error ? error.message() : "no picture is in it",
                        "name the folder with its 16-bit PNG files");
    std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
      return internal::natural_less(a.filename().string(), b.filename().string());
    });
    listen([this, folder, files, rate, read] {
      const double begin = now_s();
      for (std::size_t i = 0; i < files.size(); ++i) {
        SeenDepth seen{read(files[i]), 0};
        while (!ends_ && now_s() < begin + double(i) / rate)
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
        if (ends_) return;
        seen.time_s = now_s();
        queue_.push(std::move(seen));
      }
      throw depth_error("folder:" + folder, "its last picture was shown", "record more, or start again");
    });
  }
  ~Played() override { end(); }
};

class DepthCamera : public Listened {
 public:
  explicit DepthCamera(const std::string& number) : name_("camera:" + number) {
    int index = -1;
    const auto [stop, error] = std::from_chars(number.data(), number.data() + number.size(), index);
    if (error != std::errc() || stop != number.data() + number.size() || index < 0)
      throw Error(ErrorKind::kInput, "depth:" + name_, "it names no camera by its number",
                  "write e.g. depth:camera:0");
    by_openni_ = cv::videoio_registry::hasBackend(cv::CAP_OPENNI2);
    // Any other driver is asked for its numbers as they are.
    video_.open(index, by_openni_ ? cv::CAP_OPENNI2 : cv::CAP_ANY);
    if (!video_.isOpened())
      throw depth_error(name_, "it cannot be opened",
                        by_openni_
                            ? kNext
                            : "this OpenCV has no OpenNI2: let the sensor's own program write pictures "
                              "into a folder, and name that by depth:watch:FOLDER");
    if (!by_openni_) video_.set(cv::CAP_PROP_CONVERT_RGB, 0);
    listen([this] {
      cv::Mat picture;
      while (!ends_) {
        if (!video_.grab() || !video_.retrieve(picture, by_openni_ ? int(cv::CAP_OPENNI_DEPTH_MAP) : 0))
          throw depth_error(name_, "no more pictures come from it", kNext);
        SeenDepth seen{Image<std::uint16_t>(picture.cols, picture.rows), now_s()};
        if (picture.type() != CV_16UC1)
          throw depth_error(name_, "its pictures are not of 16 bits in one channel",
                            "choose its depth stream, or let its own program write into depth:watch:FOLDER");
        for (int y = 0; y < picture.rows; ++y)
          std::copy_n(picture.ptr<std::uint16_t>(y), picture.cols, seen.units.row(y));
        queue_.push(std::move(seen));
      }
    });
  }
  ~DepthCamera() override { end(); }

 private:
  static constexpr const char* kNext = "check its number, the cable, and that no other program uses it";
  std::string name_;
  bool by_openni_ = false;
  cv::VideoCapture video_;
};

std::unique_ptr<DepthSource> open_watched(const std::string& rest, const ReadDepth& read) {
  constexpr double kPatience = 5;  // seconds for a file to become readable
  if (!fs::is_directory(rest))
    throw depth_error("watch:" + rest, "there is no such folder",
                      "name the folder into which the sensor's pictures come");
  return std::make_unique<internal::WatchedFolder<DepthSource, SeenDepth, ReadDepth>>(rest, read, kPatience);
}

std::unique_ptr<DepthSource> open_played(const std::string& rest, const ReadDepth& read) {
  const std::size_t at = rest.rfind('@');
  double rate = 30;
  if (at != std::string::npos) {
    const char *const begin = rest.data() + at + 1, *const end = rest.data() + rest.size();
    const auto [stop, error] = std::from_chars(begin, end, rate);
    if (stop != end || error != std::errc() || !(rate >= 1e-2 && rate <= 1e3))
      throw Error(ErrorKind::kInput, "depth:folder:" + rest, "its rate is no number between 0.01 and 1000",
                  "write e.g. depth:folder:recorded@30");
  }
  return std::make_unique<Played>(rest.substr(0, at), rate, read);
}

std::unique_ptr<DepthSource> open_depth_camera(const std::string& rest, const ReadDepth&) {
  return std::make_unique<DepthCamera>(rest);
}

}  // namespace

const std::vector<DepthKind>& depth_kinds() {
  static const std::vector<DepthKind> kinds{{"watch", "watch:FOLDER", open_watched},
                                            {"folder", "folder:FOLDER[@HZ]", open_played},
                                            {"camera", "camera:NUMBER", open_depth_camera}};
  return kinds;
}

std::unique_ptr<DepthSource> open_depth(const std::string& what, const ReadDepth& read) {
  require(read != nullptr, "open_depth: files cannot be read without a reader");
  const std::size_t colon = what.find(':');
  std::string forms;
  for (const DepthKind& kind : depth_kinds()) {
    if (colon != std::string::npos && what.compare(0, colon, kind.name) == 0)
      return kind.open(what.substr(colon + 1), read);
    forms += (forms.empty() ? "" : ", ") + std::string(kind.form);
  }
  throw Error(ErrorKind::kInput, "depth source '" + what + "'", "none is called so", "say one of " + forms);
}

}  // namespace procam::device
