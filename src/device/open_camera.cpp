#include <array>
#include <filesystem>

#include "camera_kinds.hpp"
#include "procam/core/base/error.hpp"

namespace procam::device {
namespace {

/// Images whose size nobody can be asked for.
class OfSize : public FrameSource {
 public:
  OfSize(std::unique_ptr<FrameSource> source, std::string name, ImageSize size)
      : source_(std::move(source)), name_(std::move(name)), size_(size) {}
  std::optional<SeenFrame> next(double after_s, double timeout_s) override {
    std::optional<SeenFrame> frame = source_->next(after_s, timeout_s);
    if (frame && frame->image.size() != size_)
      throw Error(ErrorKind::kInput, "camera " + name_,
                  "its images have " + text(frame->image.size()) + " pixels, not " + text(size_),
                  "set its size where its images come from");
    return frame;
  }
  std::map<std::string, std::uint64_t> rejected() const override { return source_->rejected(); }
  std::string description() const override { return source_->description(); }

 private:
  static std::string text(ImageSize size) {
    return std::to_string(size.width) + "x" + std::to_string(size.height);
  }
  std::unique_ptr<FrameSource> source_;
  std::string name_;
  ImageSize size_;
};

std::unique_ptr<FrameSource> open_folder(const std::string& folder, const CameraOptions&) {
  return watch_folder(folder);
}

struct CameraKind {
  const char* name;
  bool is_driven;  ///< takes a size and an exposure
  std::unique_ptr<FrameSource> (*open)(const std::string& rest, const CameraOptions& options);
};

// One row a kind.
constexpr std::array<CameraKind, 4> kCameraKinds{{
    {"camera:", true, internal::open_video_camera},
    {"watch:", false, open_folder},
    {"ros2:", false, internal::open_ros2_camera},
    {"log:", false, internal::open_log_camera},
}};

}  // namespace

std::unique_ptr<FrameSource> open_camera(const std::string& name, const CameraOptions& options) {
  std::error_code ignored;
  const bool is_folder = std::filesystem::is_directory(name, ignored);
  std::string text = is_folder ? "watch:" + name : name;
  const CameraKind* kind = nullptr;
  for (const CameraKind& one : kCameraKinds)
    if (text.rfind(one.name, 0) == 0) kind = &one;
  if (kind == nullptr) {
    kind = &kCameraKinds.front();
    text = kind->name + text;
  }
  const std::string rest = text.substr(std::string(kind->name).size());
  if (rest.empty())
    throw Error(ErrorKind::kInput, "camera '" + name + "'", "nothing follows its kind",
                "give camera:0, watch:FOLDER or ros2:/TOPIC");
  if (!kind->is_driven && options.exposure)
    throw Error(ErrorKind::kInput, "camera " + name, "its exposure cannot be set from here",
                "set it where its images come from");
  std::unique_ptr<FrameSource> source = kind->open(rest, options);
  if (kind->is_driven || !options.size) return source;
  return std::make_unique<OfSize>(std::move(source), name, *options.size);
}

}  // namespace procam::device
