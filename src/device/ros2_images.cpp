/// Topics of the ROS 2 graph and of its logs as cameras, contents and depth cameras.
#include <thread>
#include <utility>

#include "camera_kinds.hpp"
#include "depth_listener.hpp"
#include "frame_queue.hpp"
#include "live_pictures.hpp"
#include "procam/dds/image_source.hpp"
#include "procam/device/frame_sink.hpp"
#include "procam/io/image/images.hpp"

namespace procam::device::internal {
namespace {

constexpr double kWait_s = 0.1;         ///< for an image, before asking whether to end
constexpr double kTopicPatience_s = 5;  ///< without an image or a publisher
constexpr const char* kLog = "log:";

bool is_log(const std::string& topic) {
  return topic.rfind(kLog, 0) == 0;
}

/// A source that says when it is gone: at first no image came, or its publishers have been away, for kTopicPatience_s. A
/// publisher that pauses is not gone.
template <typename Source>
class Topic {
 public:
  Topic(const std::string& topic, const char* what)
      : source_(topic),
        name_(what + ((is_log(topic) ? " " : " ros2:") + topic)),
        next_(is_log(topic) ? "start again, with a longer log"
                            : "start the node that publishes it; check the topic's name and ROS_DOMAIN_ID") {}

  /// The next image, or nullopt after a moment. Throws Error(kDevice).
  auto next() {
    auto image = source_.next(kWait_s);
    if (image || (has_any_ && source_.has_publisher())) {
      has_any_ = true;
      last_ = now_s();
    } else if (now_s() - last_ > kTopicPatience_s) {
      throw gone();
    }
    return image;
  }
  Error gone() const { return Error(ErrorKind::kDevice, name_, source_.last_error(), next_); }
  void start_again() { last_ = now_s(); }
  std::map<std::string, std::uint64_t> rejected() const { return source_.rejected(); }
  std::string description() const { return source_.description(); }

 private:
  Source source_;
  std::string name_, next_;
  bool has_any_ = false;
  double last_ = now_s();
};

class Ros2Camera : public FrameSource {
 public:
  explicit Ros2Camera(const std::string& topic) : topic_(topic, "camera") {
    listener_ = std::thread([this] { listen(); });
  }
  ~Ros2Camera() override {
    stop_ = true;
    listener_.join();
  }
  std::optional<SeenFrame> next(double after_s, double timeout_s) override {
    return queue_.next(after_s, timeout_s);
  }
  std::map<std::string, std::uint64_t> rejected() const override { return topic_.rejected(); }
  std::string description() const override { return topic_.description(); }

 private:
  void listen() {
    try {
      while (!stop_)
        if (auto image = topic_.next()) queue_.push({io::green_channel(image->pixels), image->time});
    } catch (...) {
      queue_.fail(std::current_exception());
    }
  }

  Topic<dds::ImageSource> topic_;
  FrameQueue queue_;
  std::atomic<bool> stop_{false};
  std::thread listener_;  // last: it uses all the others
};

class Ros2Pictures : public LivePictures {
 public:
  explicit Ros2Pictures(const std::string& topic) : topic_(topic, "content") {}
  bool next(ImageU8& picture) override {
    auto image = topic_.next();
    if (!image) return false;
    picture = std::move(image->pixels);
    return true;
  }
  void reopen() override { topic_.start_again(); }
  Error none() const override { return topic_.gone(); }
  std::map<std::string, std::uint64_t> rejected() const override { return topic_.rejected(); }

 private:
  Topic<dds::ImageSource> topic_;
};

class Ros2Depth : public DepthListener {
 public:
  explicit Ros2Depth(const std::string& topic) : topic_(topic, "depth camera") {
    listen([this] { read(); });
  }
  ~Ros2Depth() override { end(); }
  std::map<std::string, std::uint64_t> rejected() const override { return topic_.rejected(); }
  std::string description() const override { return topic_.description(); }

 private:
  void read() {
    while (!ends_)
      if (auto depth = topic_.next())
        queue_.push(
            {std::move(depth->pixels), depth->arrival, depth->stamp, depth->metres_per_unit, depth->camera});
  }
  Topic<dds::DepthImageSource> topic_;
};

}  // namespace

std::unique_ptr<FrameSource> open_ros2_camera(const std::string& topic, const CameraOptions&) {
  return std::make_unique<Ros2Camera>(topic);
}

std::unique_ptr<ContentSource> open_ros2_content(const std::string& topic, const ContentOptions& options) {
  return show_live(std::make_unique<Ros2Pictures>(topic), options);
}

std::unique_ptr<DepthSource> open_ros2_depth(const std::string& topic, const DepthOptions&) {
  return std::make_unique<Ros2Depth>(topic);
}

std::unique_ptr<FrameSource> open_log_camera(const std::string& log, const CameraOptions& options) {
  return open_ros2_camera(kLog + log, options);
}

std::unique_ptr<ContentSource> open_log_content(const std::string& log, const ContentOptions& options) {
  return open_ros2_content(kLog + log, options);
}

std::unique_ptr<DepthSource> open_log_depth(const std::string& log, const DepthOptions& options) {
  return open_ros2_depth(kLog + log, options);
}

}  // namespace procam::device::internal
