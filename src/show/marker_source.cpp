#include "marker_source.hpp"

#include "camera_reader.hpp"
#include "procam/core/geometry/covariance.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/track/locate.hpp"

namespace procam::show {

struct MarkerSource::State {
  RigCamera camera;
  MarkerMap map;
  MarkerCells cells;
  track::PoseQueue queue;
  std::unique_ptr<CameraReader> reader;  ///< goes first: its thread uses the others

  void look_at(const device::SeenFrame& frame) {
    require_size(frame, camera);
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
  state_->camera = camera;
  state_->map = map;
  state_->cells = cells;
  state_->reader = std::make_unique<CameraReader>(
      std::move(frames), std::move(reopen),
      [state = state_.get()](const device::SeenFrame& frame) { state->look_at(frame); });
}

MarkerSource::~MarkerSource() = default;

void MarkerSource::poll(std::vector<track::StampedPose>& arrived) {
  state_->queue.poll(arrived);
}

track::SourceStatus MarkerSource::status() const {
  return state_->reader->status(state_->queue.status());
}

std::string MarkerSource::description() const {
  return state_->reader->description();
}

std::map<std::string, std::uint64_t> MarkerSource::rejected() const {
  return state_->reader->rejected();
}

}  // namespace procam::show
