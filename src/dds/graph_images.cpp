/// Images of a topic of the graph.
#include <algorithm>
#include <mutex>
#include <utility>

#include "graph.hpp"
#include "image_input.hpp"
#include "image_messages.hpp"
#include "names.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"
#include "topic_reader.hpp"

namespace procam::dds::internal {
namespace {

constexpr int kKept = 4;  ///< images that wait to be fetched

class GraphImages : public ImageInput {
 public:
  GraphImages(const std::string& text, const char* what, TopicReader::Types types)
      : names_(parse_ros2_topic(text, what)),
        waitset_(participant_.kept(dds_create_waitset(participant_.entity()))),
        discovery_(participant_.kept(
            dds_create_reader(participant_.entity(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr))),
        images_(participant_, waitset_, names_.topic, std::move(types), kKept),
        infos_(participant_, waitset_, names_.info, {&sensor_msgs_msg_dds__CameraInfo__desc}, 1),
        before_(dropped_samples(names_.topic)) {
    if (waitset_ < 0 || discovery_ < 0)
      throw Error(ErrorKind::kDevice, "ROS 2", "DDS gives no waitset", "free memory");
    attach_data(waitset_, discovery_);
    why_ = "no publisher of " + names_.topic + " was found in ROS domain " +
           std::to_string(participant_.domain());
  }

  bool has_publisher() const override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return is_published_;
  }
  std::string last_error() const override {
    const std::lock_guard<std::mutex> lock(mutex_);
    return why_;
  }
  std::map<std::string, std::uint64_t> rejected() const override {
    const DroppedSamples dropped = dropped_samples(names_.topic);
    const std::lock_guard<std::mutex> lock(mutex_);
    std::map<std::string, std::uint64_t> all = counts_;
    if (const std::uint64_t count = dropped.undecodable - before_.undecodable; count > 0)
      all["ros2_undecodable"] = count;
    if (const std::uint64_t count = dropped.oversized - before_.oversized; count > 0)
      all["ros2_oversized"] += count;
    return all;
  }
  std::string description() const override {
    return participant_.description() + ": images of " + names_.topic;
  }

  std::optional<ReceivedImage> next_image(double timeout_s) override {
    return next(timeout_s, false,
                [this](const void* sample, const dds_sample_info_t& info,
                       double arrival) -> std::optional<ReceivedImage> {
                  const bool is_raw = images_.type() == &sensor_msgs_msg_dds__Image__desc;
                  ReceivedImage image =
                      is_raw
                          ? image_of(*static_cast<const sensor_msgs_msg_dds__Image_*>(sample), written(info))
                          : image_of(*static_cast<const sensor_msgs_msg_dds__CompressedImage_*>(sample),
                                     written(info));
                  image.time = time_of(image.stamp, arrival, info.publication_handle);
                  return image;
                });
  }
  std::optional<ReceivedDepth> next_depth(double timeout_s) override {
    return next(timeout_s, true,
                [this](const void* sample, const dds_sample_info_t& info,
                       double arrival) -> std::optional<ReceivedDepth> {
                  ReceivedDepth depth = depth_of(*static_cast<const sensor_msgs_msg_dds__Image_*>(sample),
                                                 written(info), camera_);
                  depth.arrival = arrival;
                  return depth;
                });
  }

 private:
  /// One message; `make` is given it and its arrival, and returns what next() does.
  template <typename Make>
  auto next(double timeout_s, bool with_infos, Make make)
      -> decltype(make(nullptr, dds_sample_info_t{}, 0.0)) {
    const double end = steady_now() + timeout_s;
    for (;;) {
      discover(with_infos);
      if (infos_.entity() > 0) take_infos();
      while (images_.entity() > 0) {
        void* samples[1] = {};
        dds_sample_info_t info;
        if (dds_take(images_.entity(), samples, &info, 1, 1) < 1) break;
        const double arrival = steady_now();
        decltype(make(nullptr, info, arrival)) made;
        if (info.valid_data) guarded([&] { made = make(samples[0], info, arrival); });
        dds_return_loan(images_.entity(), samples, 1);
        if (made) return made;
      }
      const double left = end - steady_now();
      if (!(left > 0)) return std::nullopt;
      dds_waitset_wait(waitset_, nullptr, 0, dds_duration_t(1e9 * std::min(left, 1.0)));
    }
  }

  void discover(bool with_infos) {
    take_all(discovery_, [&](const void* sample, const dds_sample_info_t& info, double) {
      const auto& endpoint = *static_cast<const dds_builtintopic_endpoint_t*>(sample);
      for (TopicReader* reader : {&images_, &infos_}) {
        if (reader == &infos_ && !with_infos) continue;
        if (const std::string why_not = reader->discovered(endpoint, info); !why_not.empty())
          reject({"ros2_foreign_type", why_not});
      }
    });
    const bool is_there = images_.publishers() > 0;
    const std::lock_guard<std::mutex> lock(mutex_);
    if (is_there == is_published_) return;
    is_published_ = is_there;
    why_ = is_there ? names_.topic + " has a publisher, and no image has come from it"
                    : "the publisher of " + names_.topic + " has gone";
  }

  void take_infos() {
    take_all(infos_.entity(), [&](const void* sample, const dds_sample_info_t& info, double) {
      if (!info.valid_data) return;
      camera_.reset();
      guarded([&] { camera_ = camera_of(*static_cast<const sensor_msgs_msg_dds__CameraInfo_*>(sample)); });
    });
  }

  double time_of(double stamp, double arrival, dds_instance_handle_t publisher) {
    if (clocks_.size() >= limits::kRos2Publishers && clocks_.count(publisher) == 0) clocks_.clear();
    track::Clock& clock = clocks_[publisher];
    return times_.time_of(stamp, arrival, clock);
  }

  template <typename Call>
  void guarded(Call call) {
    try {
      call();
    } catch (const Refusal& refusal) {
      reject(refusal);
    }
  }
  void reject(const Refusal& refusal) {
    const std::lock_guard<std::mutex> lock(mutex_);
    ++counts_[refusal.cause];
    why_ = "a message was dropped: " + refusal.why;
  }

  Ros2Topic names_;
  Participant participant_;
  dds_entity_t waitset_ = 0, discovery_ = 0;
  TopicReader images_, infos_;
  DroppedSamples before_;

  mutable std::mutex mutex_;  ///< of the next three
  std::map<std::string, std::uint64_t> counts_;
  std::string why_;
  bool is_published_ = false;

  std::map<dds_instance_handle_t, track::Clock> clocks_;  ///< by publisher
  ImageTimes times_;
  std::optional<Camera> camera_;
};

}  // namespace

std::unique_ptr<ImageInput> open_graph_images(const std::string& topic, ImageKind kind) {
  TopicReader::Types types = {&sensor_msgs_msg_dds__Image__desc};
  if (kind == ImageKind::kDepth) return std::make_unique<GraphImages>(topic, "depth source", types);
  types.push_back(&sensor_msgs_msg_dds__CompressedImage__desc);
  return std::make_unique<GraphImages>(topic, "image source", types);
}

}  // namespace procam::dds::internal
