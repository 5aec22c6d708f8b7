#pragma once
/// The moving surfaces of a projection: their tracks, their places for the light of a time, and the light on their markers.
#include <cstdint>
#include <vector>

#include "prediction_check.hpp"
#include "procam/core/surface/scene.hpp"
#include "procam/show/projection.hpp"

namespace procam::show {

class MovingSurfaces {
 public:
  MovingSurfaces(const MovingOptions& options, bool blank_on_stale);

  /// The surfaces of a show, by their names from then on. Throws Error(kInput) as Projection::set_show().
  void take(const SurfaceSet& set);
  void add(const track::StampedPose& message);

  /// Places those of `solved`, which was solved for the set that was taken, for the light of this time.
  void place(double light_time, const Pose& rig_from_projector, SolvedSurfaceSet& solved);
  const std::vector<MovingState>& states() const { return states_; }
  int dark_count() const { return dark_count_; }
  /// Grey value of the light that looks for bodies, in the frame that was placed last.
  std::uint8_t search_light() const;
  /// Of the surface of this number: does it move on its own, and is it dark?
  bool moves(std::size_t surface) const { return body_of_[surface] >= 0; }
  bool is_dark(std::size_t surface) const {
    return moves(surface) && states_[std::size_t(body_of_[surface])].is_dark;
  }
  /// Adds even light on the markers of bodies with a surface that is shown.
  void light_markers(const std::vector<SurfaceLight>& light, Scene& scene) const;

 private:
  struct Body {
    MovingSurface what;
    track::PoseTrack track;
    PredictionCheck check = {};
    bool is_sighted = false;  ///< since the last frame
  };
  struct Member {
    std::size_t surface = 0;
    Pose first_from_surface;
  };
  /// A body that the show has; as states_.
  struct Shown {
    std::size_t body = 0;
    std::vector<Member> members;
    Pose projector_from_first;
  };

  void judge(Body& body, const PlacedPlane& plane, const Pose& rig_from_projector, MovingState& state) const;

  MovingOptions options_;
  bool blank_on_stale_;
  std::vector<Body> bodies_;
  std::vector<Shown> shown_;
  std::vector<MovingState> states_;
  std::vector<int> body_of_;  ///< one a surface: number in shown_, -1: none
  int dark_count_ = 0;
  int marker_light_ = -1;
  std::uint8_t light_value_ = 0;
};

}  // namespace procam::show
