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
/// Odds of a second pose below which it is not considered. Light of the content on a marker biases an image: what it excludes
/// by itself may be the true pose.
constexpr double kNoOdds = 1e-6;

bool has_marker_of(const MarkerMap& map, const MarkerDetections& seen) {
  return std::any_of(seen.markers.begin(), seen.markers.end(),
                     [&](const SeenMarker& marker) { return map.find(marker.id) != nullptr; });
}

/// The poses that a hinge permits, on it. What it does not permit adds to their chi-square.
std::vector<track::PoseCandidate> on_hinge(const std::vector<track::PoseCandidate>& seen,
                                           const track::Hinge& hinge, const std::string& name) {
  std::vector<track::PoseCandidate> permitted;
  double nearest = -1;
  for (const track::PoseCandidate& candidate : seen) {
    const track::HingedPose hinged = track::on_hinge(candidate.pose, hinge);
    if (nearest < 0 || hinged.chi2 < nearest) nearest = hinged.chi2;
    if (hinged.chi2 <= kMaxHingeChi2)
      permitted.push_back({hinged.rig_from_surface, candidate.chi2 + hinged.chi2});
  }
  if (permitted.empty())
    throw Error(
        ErrorKind::kDegenerate, "surface '" + name + "'",
        "it is not where its hinge permits it: " + fixed(std::sqrt(nearest), 1) + " standard deviations",
        "correct the place of the closed surface in the surfaces file, or its markers");
  return permitted;
}

}  // namespace

SurfaceSights::SurfaceSights(const SurfaceSourceOptions& options) : options_(options) {
  require(options.readout_s >= 0, "SurfaceSights: readout_s must not be negative");
  for (const MarkedSurface& surface : options.surfaces) {
    counts_.push_back({surface.name, 0, 0, ""});
    const MarkerDictionary dictionary = surface.map.dictionary;
    if (std::find(dictionaries_.begin(), dictionaries_.end(), dictionary) != dictionaries_.end()) continue;
    dictionaries_.push_back(dictionary);
    cells_.push_back(detect::marker_cells(dictionary));
  }
  choosers_.resize(options.surfaces.size());
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
  track::SightOptions sighting_options;
  sighting_options.locate.largest_odds = kNoOdds;
  const track::SurfaceSighting sighting =
      track::sight_surface(seen, options_.camera, surface.map, sighting_options);
  const std::vector<track::PoseCandidate> candidates =
      surface.hinge ? on_hinge(sighting.poses, *surface.hinge, surface.name) : sighting.poses;
  const track::ChosenPose chosen = choosers_[i].choose(time, candidates);
  if (chosen.odds > options_.largest_odds)
    throw Error(ErrorKind::kDegenerate, "surface '" + surface.name + "'",
                "two poses fit its markers, tilted one way and the other, and no image decides",
                "put a second marker on it, larger ones, or the camera nearer; light the markers evenly");
  const PoseWithCovariance& pose = candidates[chosen.index].pose;
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
