#pragma once
/// The inputs of a show, opened as its options describe them: cameras that see the room, the light and markers, the
/// control page, and sources of poses.
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "control_page.hpp"
#include "light_watch.hpp"
#include "procam/show/projection.hpp"
#include "procam/show/run.hpp"
#include "procam/track/pose_source.hpp"
#include "room_watch.hpp"
#include "surface_source.hpp"

namespace procam::show {

/// The depth camera whose surfaces are shown on.
std::unique_ptr<DepthSurfaceSource> watch_room(const ShowOptions& options, const Rig& rig,
                                               const ProjectionOptions& projection);

/// A source of poses by its text, or of the angles of a pan-tilt head ("pan-tilt:udp:9000"), with what the mount's file
/// says about the head or about where an arm stands. Throws Error(kInput) where both do not fit together.
std::unique_ptr<track::PoseSource> open_poses(const ShowOptions& options, const std::string& text);

/// A camera on the rig whose markers give poses.
std::unique_ptr<track::PoseSource> open_markers(const MarkerInput& input, const Rig& rig);

/// `stands`: the rig stays where it is in the room, and its surfaces come from a file.
std::unique_ptr<LightWatch> watch_light(const ShowOptions& options, const Rig& rig, bool stands);

/// The camera that sees the surfaces that move on their own. `solved` has the places of the surface file. Throws Error(kInput)
/// for a hinge of a surface that has no place in the rig, and for a surface that is not there.
std::unique_ptr<SurfaceSource> open_sights(const ShowOptions& options, const Rig& rig,
                                           const MovingOptions& moving, const SolvedSurfaceSet& solved);

/// The address and the token of the control page.
ControlOptions control_options(const ShowOptions& options);

/// The poses of a source, each of which is also told to somebody.
class HeardPoses : public track::PoseSource {
 public:
  using Hear = std::function<void(const track::StampedPose&)>;
  HeardPoses(std::unique_ptr<track::PoseSource> source, Hear hear)
      : source_(std::move(source)), hear_(std::move(hear)) {}
  void poll(std::vector<track::StampedPose>& arrived) override {
    source_->poll(arrived);
    for (const track::StampedPose& message : arrived) hear_(message);
  }
  track::SourceStatus status() const override { return source_->status(); }
  std::map<std::string, std::uint64_t> rejected() const override { return source_->rejected(); }
  std::string description() const override { return source_->description(); }

 private:
  std::unique_ptr<track::PoseSource> source_;
  Hear hear_;
};

}  // namespace procam::show
