#include "prediction_check.hpp"

#include <algorithm>
#include <cmath>

#include "light_shift.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::show {
namespace {

constexpr double kFades = 300;    ///< comparisons after which one has faded to 1/e: five seconds of frames
constexpr double kBelieved = 30;  ///< comparisons that the stated covariance is worth

}  // namespace

void PredictionCheck::predicted(double light_time, const track::TrackedPose& rig_from_surface) {
  if (count_ == kKept) first_ = (first_ + 1) % kKept, --count_;
  ring_[(first_ + count_) % kKept] = {light_time, rig_from_surface.frame_from_child,
                                      rig_from_surface.covariance};
  ++count_;
}

void PredictionCheck::compare(const track::PoseTrack& track, const PlacedPlane& plane,
                              const Pose& rig_from_projector) {
  const double newest = track.newest_time();
  for (; count_ > 0 && ring_[first_].time <= newest; first_ = (first_ + 1) % kKept, --count_) {
    const Prediction& was = ring_[first_];
    const track::TrackedPose known = track.at(was.time);
    const Vec6 off = se3_log(Pose(was.pose * known.frame_from_child.inverse()));
    const double stated = mean_square_shift(plane, rig_from_projector, was.covariance - known.covariance);
    if (!(stated > 0)) continue;
    const double kept = 1 - 1 / kFades;
    moved2_ = kept * moved2_ + mean_square_shift(plane, rig_from_projector, off * off.transpose());
    stated2_ = kept * stated2_ + stated;
    compared_ = kept * compared_ + 1;
  }
}

double PredictionCheck::ratio() const {
  if (compared_ == 0) return 1;
  const double believed = kBelieved * stated2_ / compared_;
  return (moved2_ + believed) / (stated2_ + believed);
}

}  // namespace procam::show
