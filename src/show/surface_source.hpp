#pragma once
/// Surfaces that move on their own, seen by the rig's camera: a source of their poses in the rig.
///
///   SurfaceSource source(device::open_camera("0"), {rig.camera(), surfaces}, open);
///
/// Each image in which the markers of a surface are seen gives the message
///   rig_from_surface,   frame "rig", child the surface's name,
/// with the covariance of the sighting (track/sight_surface.hpp). Of two poses that fit an image, the earlier images choose
/// (track/pose_chooser.hpp); where they do not decide, there is no message. The message has no stamp: the delay from the exposure of the
/// image's middle row to its arrival is TrackOptions::delay. A rolling shutter exposes row y later than the middle one by
/// (y / (height - 1) - 1/2) readout; the message's arrival is later by that.
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "camera_reader.hpp"
#include "procam/core/board/marker.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/track/pose_source.hpp"
#include "procam/track/sight_surface.hpp"

namespace procam::show {

struct MarkedSurface {
  std::string name;
  MarkerMap map;  ///< in the surface's frame
  std::optional<track::Hinge> hinge = {};
};

struct SurfaceSourceOptions {
  RigCamera camera;
  std::vector<MarkedSurface> surfaces;
  double readout_s = 0;  ///< from the exposure of the first row to that of the last; 0: all at once
  /// Odds of the other of two poses from which on neither is taken.
  double largest_odds = 0.05;
};

/// From images to messages, without a thread.
class SurfaceSights {
 public:
  explicit SurfaceSights(const SurfaceSourceOptions& options);

  struct Surface {
    std::string name;
    std::uint64_t sightings = 0, refused = 0;  ///< images with a pose; with markers of it and without one
    std::string why;                           ///< of the last that was refused
  };

  /// The messages of an image. Throws Error(kInput) for one of another size.
  std::vector<track::StampedPose> look_at(const device::SeenFrame& frame);
  const std::vector<Surface>& surfaces() const { return counts_; }

 private:
  track::StampedPose sight(std::size_t i, const MarkerDetections& seen, double time);

  SurfaceSourceOptions options_;
  std::vector<MarkerDictionary> dictionaries_;  ///< each once
  std::vector<MarkerCells> cells_;              ///< of each
  std::vector<track::PoseChooser> choosers_;    ///< one a surface
  std::vector<Surface> counts_;
};

class SurfaceSource : public track::PoseSource {
 public:
  SurfaceSource(std::unique_ptr<device::FrameSource> frames, const SurfaceSourceOptions& options,
                CameraReader::Open reopen = {});
  ~SurfaceSource() override;

  void poll(std::vector<track::StampedPose>& arrived) override;
  /// `malformed` counts images that could not be used, and failures of the camera.
  track::SourceStatus status() const override;
  std::map<std::string, std::uint64_t> rejected() const override;
  std::string description() const override;
  std::vector<SurfaceSights::Surface> surfaces() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace procam::show
