#pragma once
/// A confirmed movement of the projector or of a surface, turned into a correction of the running show.
///
///   const Correction correction = correction_of(report, watch.projector());
///   if (correction.is_possible()) {
///     watch.correct(correction.projector, correction.covariance);
///     Glide glide(rig_from_projector, correction.projector.rig_from_projector, correction.error, now);
///   }                                              // then, frame by frame: projection.move_projector(glide.at(now))
///
/// Only a movement with one plausible cause is corrected. Of a rig that stands still the projector is also the cause of an error
/// that has grown as slowly as that of a lamp which warms up (WatchReport::is_drift), where it is one of the plausible ones:
/// walls do not creep. With true rig_from_projector = exp(x) rig_from_projector and the
/// estimate x with covariance C (movement.hpp; C includes what rig and lens were known to before), the corrected pose is
/// exp(x) rig_from_projector, and C is its covariance. The same holds for a surface where CorrectionOptions::surfaces allows
/// it. Its movement along itself moves no light; nothing sees it, and nothing corrects it.
#include <string>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/covariance.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/watch/watch.hpp"

namespace procam::watch {

struct CorrectionOptions {
  double max_rotation = 5 * kDegree, max_shift = 0.1;  ///< more is another set-up: radians, metres
  double max_sigma = 0.3;                              ///< of the error, as a share of it: less certain waits
  /// A surface that has moved is corrected as well. For a rig that stands still: a movement of the rig that explains the
  /// light no better than that of one surface is not considered.
  bool surfaces = false;
};

struct Correction {
  RigProjector projector;  ///< as it stands now
  Mat6 covariance =
      Mat6::Zero();           ///< of `moved`; for the projector, of rig_from_projector relative to the camera
  std::string surface;        ///< the one that moved; empty: the projector
  Vec6 moved = Vec6::Zero();  ///< left increment in the rig's frame, of either
  double error = 0;           ///< of the light before the correction, metres RMS on the surfaces
  std::string sentence;       ///< for people: what moved and by how much, or why nothing is corrected

  bool is_possible() const { return error > 0; }
};

/// What to do about an alarm. Without an alarm nothing, and no sentence.
PROCAM_EXPORT Correction correction_of(const WatchReport& report, const RigProjector& projector,
                                       const CorrectionOptions& options = {});

/// The rig with the corrected projector (not for a surface). Its pose was measured from `camera`: it has that camera's correlations, and
/// `covariance` beside its own. A rig without covariance stays without.
PROCAM_EXPORT Rig corrected_rig(Rig rig, const Correction& correction, const std::string& camera);

/// From one pose to another along exp(s xi), in a time in which the light moves no faster than `rate`.
class PROCAM_EXPORT Glide {
 public:
  /// `error`: how far the light moves, metres; `rate` metres a second.
  Glide(const Pose& from, const Pose& to, double error, double begin, double rate = 0.005);
  Pose at(double time) const;
  bool is_over(double time) const { return time >= begin_ + duration_; }

 private:
  Pose from_, to_;
  Vec6 way_;  ///< to = exp(way) from
  double begin_, duration_;
};

}  // namespace procam::watch
