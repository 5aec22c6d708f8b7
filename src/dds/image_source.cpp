#include "procam/dds/image_source.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <utility>

#include "camera_info.hpp"
#include "graph.hpp"
#include "image_pixels.hpp"
#include "messages.hpp"
#include "names.hpp"
#include "procam/core/base/clock.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/base/limits.hpp"
#include "procam/track/clock.hpp"
#include "topic_reader.hpp"

namespace procam::dds {
namespace {

using internal::Refusal;
using internal::TopicReader;

constexpr int kKept = 4;  ///< images that wait to be fetched

std::string text_of(const char* text) {
  return text == nullptr ? "" : text;
}

internal::RawImage raw_image(const sensor_msgs_msg_dds__Image_& message) {
  internal::RawImage raw;
  raw.width = message.width;
  raw.height = message.height;
  raw.encoding = text_of(message.encoding);
  raw.is_big_endian = message.is_bigendian != 0;
  raw.step = message.step;
  raw.data = message.data._buffer;
  raw.size = message.data._length;
  return raw;
}

internal::RawCameraInfo raw_camera_info(const sensor_msgs_msg_dds__CameraInfo_& message) {
  internal::RawCameraInfo raw;
  raw.width = message.width;
  raw.height = message.height;
  raw.model = text_of(message.distortion_model);
  // One more than any model has is enough to see that it is wrong.
  raw.d.assign(message.d._buffer, message.d._buffer + std::min(message.d._length, 15u));
  std::copy_n(message.k, 9, raw.k.begin());
  raw.binning_x = message.binning_x;
  raw.binning_y = message.binning_y;
  raw.roi_x = message.roi.x_offset;
  raw.roi_y = message.roi.y_offset;
  raw.roi_width = message.roi.width;
  raw.roi_height = message.roi.height;
  return raw;
}

}  // namespace

struct ImageTopic::Impl {
  internal::Ros2Topic names;
  internal::Participant participant;
  dds_entity_t waitset = 0, discovery = 0;
  TopicReader images, infos;
  internal::DroppedSamples before;

  mutable std::mutex mutex;  ///< of the next three
  std::map<std::string, std::uint64_t> counts;
  std::string why;
  bool is_published = false;

  std::map<dds_instance_handle_t, track::Clock> clocks;  ///< by publisher
  double last_time = -std::numeric_limits<double>::infinity();
  std::optional<Camera> camera;

  Impl(const std::string& text, const char* what, TopicReader::Types types)
      : names(internal::parse_ros2_topic(text, what)),
        waitset(dds_create_waitset(participant.entity())),
        discovery(
            dds_create_reader(participant.entity(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr)),
        images(participant, waitset, names.topic, std::move(types), kKept),
        infos(participant, waitset, names.info, {&sensor_msgs_msg_dds__CameraInfo__desc}, 1),
        before(internal::dropped_samples(names.topic)) {
    if (waitset < 0 || discovery < 0)
      throw Error(ErrorKind::kDevice, "ROS 2", "DDS gives no waitset", "free memory");
    dds_set_status_mask(discovery, DDS_DATA_AVAILABLE_STATUS);
    dds_waitset_attach(waitset, discovery, 0);
    why =
        "no publisher of " + names.topic + " was found in ROS domain " + std::to_string(participant.domain());
  }

  /// One message; `make` is given it and its arrival, and returns what next() does.
  template <typename Make>
  auto next(double timeout_s, bool with_infos, Make make)
      -> decltype(make(nullptr, dds_sample_info_t{}, 0.0)) {
    const double end = steady_now() + timeout_s;
    for (;;) {
      discover(with_infos);
      if (infos.entity() > 0) take_infos();
      while (images.entity() > 0) {
        void* samples[1] = {};
        dds_sample_info_t info;
        if (dds_take(images.entity(), samples, &info, 1, 1) < 1) break;
        const double arrival = steady_now();
        decltype(make(nullptr, info, arrival)) made;
        if (info.valid_data) guarded([&] { made = make(samples[0], info, arrival); });
        dds_return_loan(images.entity(), samples, 1);
        if (made) return made;
      }
      const double left = end - steady_now();
      if (!(left > 0)) return std::nullopt;
      dds_waitset_wait(waitset, nullptr, 0, dds_duration_t(1e9 * std::min(left, 1.0)));
    }
  }

  void discover(bool with_infos) {
    internal::take_all(discovery, [&](const void* sample, const dds_sample_info_t& info, double) {
      const auto& endpoint = *static_cast<const dds_builtintopic_endpoint_t*>(sample);
      for (TopicReader* reader : {&images, &infos}) {
        if (reader == &infos && !with_infos) continue;
        if (const std::string why_not = reader->discovered(endpoint, info); !why_not.empty())
          reject({"ros2_foreign_type", why_not});
      }
    });
    const bool is_there = images.publishers() > 0;
    const std::lock_guard<std::mutex> lock(mutex);
    if (is_there == is_published) return;
    is_published = is_there;
    why = is_there ? names.topic + " has a publisher, and no image has come from it"
                   : "the publisher of " + names.topic + " has gone";
  }

  void take_infos() {
    internal::take_all(infos.entity(), [&](const void* sample, const dds_sample_info_t& info, double) {
      if (!info.valid_data) return;
      camera.reset();
      guarded([&] {
        camera = internal::camera_of(
            raw_camera_info(*static_cast<const sensor_msgs_msg_dds__CameraInfo_*>(sample)));
      });
    });
  }

  double time_of(double stamp, double arrival, dds_instance_handle_t publisher) {
    if (clocks.size() >= limits::kRos2Publishers && clocks.count(publisher) == 0) clocks.clear();
    track::Clock& clock = clocks[publisher];
    double time = arrival;
    if (clock.observe(stamp, arrival) != track::ClockVerdict::kDoubtful)
      time = std::min(clock.time(stamp), arrival);
    // In the order of arrival: whoever asks for what came after an image asks by its time.
    last_time = std::max(time, std::nextafter(last_time, std::numeric_limits<double>::infinity()));
    return last_time;
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
    const std::lock_guard<std::mutex> lock(mutex);
    ++counts[refusal.cause];
    why = "a message was dropped: " + refusal.why;
  }
};

ImageTopic::ImageTopic(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ImageTopic::ImageTopic(ImageTopic&&) noexcept = default;
ImageTopic& ImageTopic::operator=(ImageTopic&&) noexcept = default;
ImageTopic::~ImageTopic() = default;

bool ImageTopic::has_publisher() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  return impl_->is_published;
}

std::string ImageTopic::last_error() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  return impl_->why;
}

std::map<std::string, std::uint64_t> ImageTopic::rejected() const {
  const internal::DroppedSamples dropped = internal::dropped_samples(impl_->names.topic);
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  std::map<std::string, std::uint64_t> counts = impl_->counts;
  if (const std::uint64_t count = dropped.undecodable - impl_->before.undecodable; count > 0)
    counts["ros2_undecodable"] = count;
  if (const std::uint64_t count = dropped.oversized - impl_->before.oversized; count > 0)
    counts["ros2_oversized"] += count;
  return counts;
}

std::string ImageTopic::description() const {
  return impl_->participant.description() + ": images of " + impl_->names.topic;
}

ImageSource::ImageSource(const std::string& text)
    : ImageTopic(std::make_unique<Impl>(text, "image source",
                                        TopicReader::Types{&sensor_msgs_msg_dds__Image__desc,
                                                           &sensor_msgs_msg_dds__CompressedImage__desc})) {}

std::optional<ReceivedImage> ImageSource::next(double timeout_s) {
  Impl& impl = *impl_;
  return impl.next(
      timeout_s, false,
      [&](const void* sample, const dds_sample_info_t& info, double arrival) -> std::optional<ReceivedImage> {
        ReceivedImage image;
        if (impl.images.type() == &sensor_msgs_msg_dds__Image__desc) {
          const auto& message = *static_cast<const sensor_msgs_msg_dds__Image_*>(sample);
          image.stamp = internal::stamp_of(message.header.stamp, internal::written(info));
          image.pixels = internal::pixels_of(raw_image(message));
        } else {
          const auto& message = *static_cast<const sensor_msgs_msg_dds__CompressedImage_*>(sample);
          image.stamp = internal::stamp_of(message.header.stamp, internal::written(info));
          image.pixels = internal::decompressed(
              std::string(reinterpret_cast<const char*>(message.data._buffer), message.data._length));
        }
        image.time = impl.time_of(image.stamp, arrival, info.publication_handle);
        return image;
      });
}

DepthImageSource::DepthImageSource(const std::string& text)
    : ImageTopic(std::make_unique<Impl>(text, "depth source",
                                        TopicReader::Types{&sensor_msgs_msg_dds__Image__desc})) {}

std::optional<ReceivedDepth> DepthImageSource::next(double timeout_s) {
  Impl& impl = *impl_;
  return impl.next(
      timeout_s, true,
      [&](const void* sample, const dds_sample_info_t& info, double arrival) -> std::optional<ReceivedDepth> {
        const auto& message = *static_cast<const sensor_msgs_msg_dds__Image_*>(sample);
        ReceivedDepth depth;
        depth.stamp = internal::stamp_of(message.header.stamp, internal::written(info));
        depth.pixels = internal::depth_of(raw_image(message));
        depth.arrival = arrival;
        constexpr double kMillimetre = 1e-3;
        if (std::holds_alternative<Image<std::uint16_t>>(depth.pixels)) depth.metres_per_unit = kMillimetre;
        if (impl.camera && impl.camera->size == size_of(depth.pixels)) depth.camera = impl.camera;
        return depth;
      });
}

}  // namespace procam::dds
