#include "surface_source.hpp"

#include <algorithm>
#include <mutex>
#include <utility>

#include "procam/core/base/words.hpp"
#include "procam/detect/marker_edges.hpp"

namespace procam::show {
namespace {

/// A pose that the hinge permits by chance in 1 of 10^6, with 5 degrees of freedom; the rest is another object.
constexpr double kMaxHingeChi2 = 36;

bool has_marker_of(const MarkerMap& map, const MarkerDetections& seen) {
  return std::any_of(seen.markers.begin(), seen.markers.end(),
                     [&](const SeenMarker& marker) { return map.find(marker.id) != nullptr; });
}

}  // namespace

SurfaceSights::SurfaceSights(const SurfaceSourceOptions& options) : options_(options) {
  require(options.readout_s >= 0 && options.previous_within >= 0,
          "SurfaceSights: readout_s and previous_within must not be negative");
  for (const MarkedSurface& surface : options.surfaces) {
    counts_.push_back({surface.name, 0, 0, ""});
    const MarkerDictionary dictionary = surface.map.dictionary;
    if (std::find(dictionaries_.begin(), dictionaries_.end(), dictionary) != dictionaries_.end()) continue;
    dictionaries_.push_back(dictionary);
    cells_.push_back(detect::marker_cells(dictionary));
  }
  previous_.resize(options.surfaces.size());
}

std::vector<track::StampedPose> SurfaceSights::look_at(const device::SeenFrame& frame) {
  require_size(frame, options_.camera);
  std::vector<track::StampedPose> messages;
  for (std::size_t d = 0; d < dictionaries_.size(); ++d) {
    const MarkerDetections seen =
        detect::detect_marker_edges(frame.image, cells_[d], {options_.camera.camera});
    for (std::size_t i = 0; i < options_.surfaces.size(); ++i) {
      const MarkerMap& map = options_.surfaces[i].map;
      if (map.dictionary != dictionaries_[d] || !has_marker_of(map, seen)) continue;
      try {
        messages.push_back(sight(i, seen, frame.time_s));
        ++counts_[i].sightings;
      } catch (const Error& error) {
        ++counts_[i].refused;
        counts_[i].why = error.what();
      }
    }
  }
  return messages;
}

track::StampedPose SurfaceSights::sight(std::size_t i, const MarkerDetections& seen, double time) {
  const MarkedSurface& surface = options_.surfaces[i];
  std::optional<Pose> previous;
  if (previous_[i] && time - previous_[i]->time <= options_.previous_within)
    previous = previous_[i]->rig_from_surface;
  const track::SurfaceSighting sighting = track::sight_surface(seen, options_.camera, surface.map, previous);
  PoseWithCovariance pose = sighting.rig_from_surface;
  if (surface.hinge) {
    const track::HingedPose hinged = track::on_hinge(pose, *surface.hinge);
    if (hinged.chi2 > kMaxHingeChi2)
      throw Error(ErrorKind::kDegenerate, "surface '" + surface.name + "'",
                  "it is not where its hinge permits it: " + fixed(std::sqrt(hinged.chi2), 1) +
                      " standard deviations",
                  "correct the place of the closed surface in the surfaces file, or its markers");
    pose = hinged.rig_from_surface;
  }
  previous_[i] = Previous{pose.pose, time};
  const double rows = std::max(1, options_.camera.camera.size.height - 1);
  track::StampedPose message;
  message.arrival = time + options_.readout_s * (sighting.row / rows - 0.5);
  message.frame = "rig";
  message.child = surface.name;
  message.frame_from_child = pose.pose;
  message.covariance = pose.covariance;
  return message;
}

struct SurfaceSource::State {
  explicit State(const SurfaceSourceOptions& options) : sights(options), counts(sights.surfaces()) {}

  SurfaceSights sights;  ///< the thread's own
  track::PoseQueue queue;
  std::mutex mutex;  ///< of the next
  std::vector<SurfaceSights::Surface> counts;
  std::unique_ptr<CameraReader> reader;  ///< goes first: its thread uses the others

  void look_at(const device::SeenFrame& frame) {
    for (track::StampedPose& message : sights.look_at(frame)) queue.push(std::move(message));
    const std::lock_guard<std::mutex> lock(mutex);
    counts = sights.surfaces();
  }
};

SurfaceSource::SurfaceSource(std::unique_ptr<device::FrameSource> frames, const SurfaceSourceOptions& options,
                             CameraReader::Open reopen)
    : state_(std::make_unique<State>(options)) {
  state_->reader = std::make_unique<CameraReader>(
      std::move(frames), std::move(reopen),
      [state = state_.get()](const device::SeenFrame& frame) { state->look_at(frame); });
}

SurfaceSource::~SurfaceSource() = default;

void SurfaceSource::poll(std::vector<track::StampedPose>& arrived) {
  state_->queue.poll(arrived);
}

track::SourceStatus SurfaceSource::status() const {
  return state_->reader->status(state_->queue.status());
}

std::map<std::string, std::uint64_t> SurfaceSource::rejected() const {
  return state_->reader->rejected();
}

std::string SurfaceSource::description() const {
  return state_->reader->description();
}

std::vector<SurfaceSights::Surface> SurfaceSource::surfaces() const {
  const std::lock_guard<std::mutex> lock(state_->mutex);
  return state_->counts;
}

}  // namespace procam::show
