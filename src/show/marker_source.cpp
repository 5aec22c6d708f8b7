#include "marker_source.hpp"

#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

#include "procam/core/geometry/covariance.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/track/locate.hpp"
#include "rejected_counts.hpp"

namespace procam::show {

struct MarkerSource::State {
  std::unique_ptr<device::FrameSource> frames;
  std::string description;  ///< of the first
  RigCamera camera;
  MarkerMap map;
  MarkerCells cells;
  Open reopen;
  track::PoseQueue queue;
  RejectedCounts rejected;
  std::atomic<bool> ends{false}, connected{true};
  std::mutex mutex;  ///< of the two below
  std::uint64_t without = 0;
  std::string why;
  std::thread thread;

  void run() {
    double after = 0;
    while (!ends) {
      try {
        if (!frames) {
          frames = reopen();
          connected = true;
        }
        // Only the newest is of use: what arrived while the last one was looked at is passed over.
        std::optional<device::SeenFrame> frame = frames->next(after, 0.1);
        while (auto newer = frame && !ends ? frames->next(frame->time_s, 0) : std::nullopt)
          frame = std::move(newer);
        rejected.note(frames->rejected());
        if (!frame) continue;
        after = frame->time_s;
        look_at(*frame);
      } catch (const std::exception& error) {
        {
          const std::lock_guard<std::mutex> lock(mutex);
          ++without;
          why = error.what();
        }
        // A frame without markers is followed by others; a camera that is gone has to be opened again.
        const auto* known = dynamic_cast<const Error*>(&error);
        if (frames && (known == nullptr || known->kind() != ErrorKind::kDevice)) continue;
        connected = false;
        if (!reopen) return;
        if (frames) rejected.note(frames->rejected());
        frames.reset();
        rejected.closed();
        for (int i = 0; i < 20 && !ends; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(50));
      }
    }
  }

  void look_at(const device::SeenFrame& frame) {
    if (frame.image.size() != camera.camera.size)
      throw Error(ErrorKind::kInput, "camera", "its frames are not of the size it was calibrated with",
                  "set its mode to that of the rig file");
    const MarkerDetections seen = detect::detect_marker_edges(frame.image, cells, {camera.camera});
    const track::LocateResult located = track::locate(seen, camera.camera, map);
    const PoseWithCovariance rig_from_world =
        compose({camera.rig_from_camera, Mat6::Zero()}, {located.camera_from_world, located.covariance});
    const PoseWithCovariance world_from_rig = inverse(rig_from_world);
    track::StampedPose message;
    message.arrival = frame.time_s;
    message.frame = "world";
    message.child = "rig";
    message.frame_from_child = world_from_rig.pose.normalized();
    message.covariance = world_from_rig.covariance;
    queue.push(std::move(message));
  }
};

MarkerSource::MarkerSource(std::unique_ptr<device::FrameSource> frames, const RigCamera& camera,
                           const MarkerMap& map, const MarkerCells& cells, Open reopen)
    : state_(std::make_unique<State>()) {
  require(frames != nullptr, "MarkerSource: no frames");
  state_->description = frames->description();
  state_->frames = std::move(frames);
  state_->camera = camera;
  state_->map = map;
  state_->cells = cells;
  state_->reopen = std::move(reopen);
  state_->thread = std::thread([state = state_.get()] { state->run(); });
}

MarkerSource::~MarkerSource() {
  state_->ends = true;
  state_->thread.join();
}

void MarkerSource::poll(std::vector<track::StampedPose>& arrived) {
  state_->queue.poll(arrived);
}

track::SourceStatus MarkerSource::status() const {
  track::SourceStatus status = state_->queue.status();
  const std::lock_guard<std::mutex> lock(state_->mutex);
  status.connected = state_->connected;
  status.malformed += state_->without;
  if (!state_->why.empty()) status.last_error = state_->why;
  return status;
}

std::string MarkerSource::description() const {
  return state_->description;
}

std::map<std::string, std::uint64_t> MarkerSource::rejected() const {
  return state_->rejected.counts();
}

}  // namespace procam::show
