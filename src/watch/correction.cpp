#include "procam/watch/correction.hpp"

#include <algorithm>

#include "procam/core/base/words.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam::watch {

namespace {

/// The one cause that a correction may take; null: there is none, and `why` says so.
const Explanation* cause_of(const WatchReport& report, const CorrectionOptions& options, std::string& why) {
  std::vector<const Explanation*> causes = report.estimate->plausible();
  if (causes.empty() || (report.state != WatchState::kMoved && report.state != WatchState::kInseparable))
    return nullptr;
  // What a rig that moved would do to one surface's light, that surface does alone: of the two it is the surface.
  const auto is_surface = [](const Explanation* one) { return one->thing == MovedThing::kSurface; };
  const auto is_rig = [](const Explanation* one) { return one->thing == MovedThing::kRig; };
  const auto projector = std::find_if(causes.begin(), causes.end(), [](const Explanation* one) {
    return one->thing == MovedThing::kProjector;
  });
  if (options.surfaces && report.is_drift && projector != causes.end()) return *projector;
  bool is_only_one = report.state == WatchState::kMoved;
  if (options.surfaces && std::any_of(causes.begin(), causes.end(), is_surface)) {
    causes.erase(std::remove_if(causes.begin(), causes.end(), is_rig), causes.end());
    is_only_one = causes.size() == 1;
  }
  if (!is_only_one) {
    why = "the causes cannot be separated";
    return nullptr;
  }
  const Explanation& cause = *causes.front();
  if (cause.thing == MovedThing::kProjector || (cause.thing == MovedThing::kSurface && options.surfaces))
    return &cause;
  why = cause.name + " has moved, not the projector; place the surfaces again";
  return nullptr;
}

}  // namespace

Correction correction_of(const WatchReport& report, const RigProjector& projector,
                         const CorrectionOptions& options) {
  Correction out;
  out.projector = projector;
  if (!report.is_alarm || !report.estimate) return out;
  std::string why;
  const Explanation* const cause = cause_of(report, options, why);
  if (cause == nullptr) {
    if (!why.empty()) out.sentence = "not corrected: " + why;
    return out;
  }
  const double degrees = cause->moved.head<3>().norm() / kDegree;
  if (degrees * kDegree > options.max_rotation || cause->shift > options.max_shift) {
    out.sentence = "not corrected: a movement of " + fixed(degrees, 1) + " deg and " + mm(cause->shift, 0) +
                   " is another set-up; calibrate again";
  } else if (cause->error_sigma > options.max_sigma * cause->error) {
    out.sentence =
        "not corrected yet: the error is " + mm(cause->error, 1) + " +- " + mm(cause->error_sigma, 1);
  } else {
    out.error = cause->error;
    out.moved = cause->moved;
    out.covariance = cause->covariance;
    if (cause->thing == MovedThing::kSurface)
      out.surface = cause->name;
    else
      out.projector.rig_from_projector =
          (se3_exp<double>(cause->moved) * projector.rig_from_projector).normalized();
    out.sentence = "corrected: " + cause->name + " rotated by " + fixed(degrees, 2) + " deg and moved by " +
                   mm(cause->shift, 1) + ", the light was off by " + mm(cause->error, 1) +
                   (report.is_drift ? " and has drifted there" : "");
  }
  return out;
}

Rig corrected_rig(Rig rig, const Correction& correction, const std::string& camera) {
  for (RigProjector& projector : rig.projectors)
    if (projector.name == correction.projector.name)
      projector.rig_from_projector = correction.projector.rig_from_projector;
  MatX& matrix = rig.covariance.matrix;
  const auto of_projector = pose_increment_names("rig_from_" + correction.projector.name),
             of_camera = pose_increment_names("rig_from_" + camera);
  for (int i = 0; i < 6; ++i) {
    const auto row = rig.covariance.index_of(of_projector[std::size_t(i)]);
    if (!row) return rig;
    // The first camera is the frame itself: nothing is uncertain there.
    const auto as = rig.covariance.index_of(of_camera[std::size_t(i)]);
    const VecX like = as ? VecX(matrix.row(*as)) : VecX::Zero(matrix.cols());
    matrix.row(*row) = like;
    matrix.col(*row) = like;
  }
  // The block of the projector with itself, after all its rows were replaced: that of the camera and the measurement's.
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      const auto row = rig.covariance.index_of(of_projector[std::size_t(i)]),
                 column = rig.covariance.index_of(of_projector[std::size_t(j)]);
      const auto of_row = rig.covariance.index_of(of_camera[std::size_t(i)]),
                 of_column = rig.covariance.index_of(of_camera[std::size_t(j)]);
      matrix(*row, *column) =
          correction.covariance(i, j) + (of_row && of_column ? matrix(*of_row, *of_column) : 0);
    }
  return rig;
}

Glide::Glide(const Pose& from, const Pose& to, double error, double begin, double rate)
    : from_(from), to_(to), way_(se3_log(Pose(to * from.inverse()))), begin_(begin), duration_(error / rate) {
  require(rate > 0 && error >= 0, "Glide: the rate is positive");
}

Pose Glide::at(double time) const {
  if (is_over(time)) return to_;
  const double share = std::max(0.0, (time - begin_) / duration_);
  return (se3_exp<double>(Vec6(share * way_)) * from_).normalized();
}

}  // namespace procam::watch
