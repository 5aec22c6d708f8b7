#pragma once
/// How far predictions of a moving surface were off, seen afterwards.
///
/// The covariance of PoseTrack allows for a body that may brake at any time; most do not, most of the time. A prediction for
/// the light of a time t is kept. When sightings have passed t, the track knows the pose at t better, and
///
///   moved^2 = mean square shift of the light by log(T_predicted T_known^-1)           over the corners of the content
///   stated^2 = mean square shift by C_predicted - C_known                              (light_shift.hpp)
///
/// are summed with weights that fade within some seconds. ratio() = sum moved^2 / sum stated^2, begun at 1, is the factor on what a
/// prediction adds to the variance of the known pose.
#include <array>
#include <cstddef>

#include "procam/core/surface/planar.hpp"
#include "procam/track/pose_track.hpp"

namespace procam::show {

class PredictionCheck {
 public:
  /// What was drawn for.
  void predicted(double light_time, const track::TrackedPose& rig_from_surface);
  /// Compares those that the track's newest pose has passed. `plane`: with content, as it is placed now.
  void compare(const track::PoseTrack& track, const PlacedPlane& plane, const Pose& rig_from_projector);
  double ratio() const;

 private:
  static constexpr std::size_t kKept = 64;  ///< predictions: a second of frames
  struct Prediction {
    double time = 0;
    Pose pose;
    Mat6 covariance = Mat6::Zero();
  };
  std::array<Prediction, kKept> ring_;
  std::size_t first_ = 0, count_ = 0;
  double moved2_ = 0, stated2_ = 0, compared_ = 0;
};

}  // namespace procam::show
