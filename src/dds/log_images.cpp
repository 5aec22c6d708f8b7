/// Images of a topic of a log, each when it is due.
#include <chrono>
#include <mutex>
#include <thread>
#include <utility>

#include "cdr_sample.hpp"
#include "image_input.hpp"
#include "image_messages.hpp"
#include "log_playback.hpp"
#include "names.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/core/base/error.hpp"
#include "topic_reader.hpp"

namespace procam::dds::internal {
namespace {

/// Images that are later than this, as of a computer that is too slow, are skipped while others follow.
constexpr double kLate_s = 0.5;

class LogImages : public ImageInput {
 public:
  LogImages(const LogText& text, ImageKind kind) : file_(text.file), log_(open_message_log(text.file)) {
    if (text.speed == 0)
      throw Error(ErrorKind::kInput, "log " + file_.string(), "images cannot be given all at once",
                  "give a speed, e.g. @1 or @10");
    std::vector<std::string> types = {name_of(sensor_msgs_msg_dds__Image__desc)};
    if (kind == ImageKind::kImage) types.push_back(name_of(sensor_msgs_msg_dds__CompressedImage__desc));
    Ros2Topic names;
    if (!text.what.empty()) names = parse_ros2_topic(text.what, "images", "log:" + file_.string() + "+");
    topics_ = topics_of(*log_, types, names.topic);
    if (topics_.size() != 1) refuse(names.topic, types);
    topic_ = log_->topics()[topics_.front()].name;
    is_raw_ = log_->topics()[topics_.front()].type == types.front();
    if (kind == ImageKind::kDepth) take_infos(names.info);
    log_->select(topics_);
    times_ = shared_times(text, log_->begin_ns());
  }

  bool has_publisher() const override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return !has_ended_;
  }
  std::string last_error() const override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return why_;
  }
  std::map<std::string, std::uint64_t> rejected() const override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return counts_;
  }
  std::string description() const override {
    return file_.string() + ": images of " + topic_ + (log_->notice().empty() ? "" : "; " + log_->notice());
  }

  std::optional<ReceivedImage> next_image(double timeout_s) override {
    return next<ReceivedImage>(timeout_s, [this](double logged, double due) {
      ReceivedImage image =
          is_raw_
              ? image_of(*static_cast<const sensor_msgs_msg_dds__Image_*>(raw_.read(waiting_.bytes)), logged)
              : image_of(*static_cast<const sensor_msgs_msg_dds__CompressedImage_*>(
                             compressed_.read(waiting_.bytes)),
                         logged);
      image.time = times_->speed() == 1 ? order_.time_of(image.stamp, due, clock_) : order_.next(due);
      return image;
    });
  }
  std::optional<ReceivedDepth> next_depth(double timeout_s) override {
    return next<ReceivedDepth>(timeout_s, [this](double logged, double due) {
      ReceivedDepth depth = depth_of(
          *static_cast<const sensor_msgs_msg_dds__Image_*>(raw_.read(waiting_.bytes)), logged, camera_);
      depth.arrival = due;
      return depth;
    });
  }

 private:
  static std::string name_of(const dds_topic_descriptor_t& type) { return ros_type(type.m_typename); }

  [[noreturn]] void refuse(const std::string& topic, const std::vector<std::string>& types) const {
    throw Error(ErrorKind::kInput, "log " + file_.string(),
                topic.empty() ? "it does not hold one topic of images to take"
                              : "it holds no images of the topic " + topic,
                "give log:FILE+/TOPIC; it holds " + topic_list(*log_, topics_of(*log_, types)));
  }

  void take_infos(std::string name) {
    if (name.empty()) name = topic_.substr(0, topic_.rfind('/')) + "/camera_info";
    for (const std::size_t info : topics_of(*log_, {name_of(sensor_msgs_msg_dds__CameraInfo__desc)}, name))
      topics_.push_back(info);
  }

  /// The next one that is due within the time; `make` is given when it was logged and is due.
  template <typename Received, typename Make>
  std::optional<Received> next(double timeout_s, Make make) {
    const double end = steady_now() + timeout_s;
    for (;;) {
      if (!is_waiting_ && !read_on()) {
        sleep_until(end);
        return std::nullopt;
      }
      if (!is_waiting_) {
        if (steady_now() > end) return std::nullopt;  // much is late: the next call goes on
        continue;
      }
      const double due = times_->due(waiting_.logged_ns);
      if (due > end) {
        sleep_until(end);
        return std::nullopt;
      }
      sleep_until(due);
      is_waiting_ = false;
      try {
        return make(1e-9 * double(waiting_.logged_ns), due);
      } catch (const Refusal& refusal) {
        reject(refusal);
      }
    }
  }

  /// false at the end. An image waits then, or a CameraInfo was taken.
  bool read_on() {
    try {
      // An image that is late is skipped, unless it is the last one: its bytes are kept until the next is there.
      if (!log_->next(waiting_)) {
        const std::lock_guard<std::mutex> lock(mutex_);
        has_ended_ = true;
        why_ = "the log has ended";
        if (late_.empty()) return false;
        last_ = std::exchange(late_, {});
        waiting_.bytes = last_;
        waiting_.logged_ns = late_ns_;
        return is_waiting_ = true;
      }
      if (waiting_.topic != topics_.front()) {
        camera_.reset();
        camera_ =
            camera_of(*static_cast<const sensor_msgs_msg_dds__CameraInfo_*>(info_.read(waiting_.bytes)));
      } else if (times_->due(waiting_.logged_ns) < steady_now() - kLate_s) {
        late_.assign(waiting_.bytes);
        late_ns_ = waiting_.logged_ns;
      } else {
        late_.clear();
        is_waiting_ = true;
      }
    } catch (const Refusal& refusal) {
      reject(refusal);
    }
    return true;
  }

  static void sleep_until(double time) {
    const double left = time - steady_now();
    if (left > 0) std::this_thread::sleep_for(std::chrono::duration<double>(left));
  }

  void reject(const Refusal& refusal) {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++counts_[refusal.cause];
    why_ = "a message was dropped: " + refusal.why;
  }

  const std::filesystem::path file_;
  std::unique_ptr<MessageLog> log_;
  std::vector<std::size_t> topics_;  ///< the images', then that of their CameraInfo
  std::string topic_;
  bool is_raw_ = true;  ///< or compressed
  std::shared_ptr<const LogTimes> times_;
  CdrSample raw_{sensor_msgs_msg_dds__Image__desc}, compressed_{sensor_msgs_msg_dds__CompressedImage__desc},
      info_{sensor_msgs_msg_dds__CameraInfo__desc};
  LoggedMessage waiting_;
  bool is_waiting_ = false;
  std::string late_, last_;  ///< an image that was skipped
  std::int64_t late_ns_ = 0;
  track::Clock clock_;
  ImageTimes order_;
  std::optional<Camera> camera_;

  mutable std::mutex mutex_;  ///< of the next three
  std::map<std::string, std::uint64_t> counts_;
  std::string why_ = "no image of the log has come yet";
  bool has_ended_ = false;
};

}  // namespace

std::unique_ptr<ImageInput> open_log_images(const std::string& rest, ImageKind kind) {
  return std::make_unique<LogImages>(parse_log_text(rest), kind);
}

}  // namespace procam::dds::internal
