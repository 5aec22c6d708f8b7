#pragma once
/// The quality check on the predicted error itself. The other checks (calibrate/gates.hpp) ask whether the
/// numbers of a rig are possible; this one asks whether they are known well enough for the user's surface.
/// It stands here because the error needs light_error.hpp, which knows walls and is no part of calibration.
#include <string>
#include <vector>

#include "procam/analyze/light_error.hpp"
#include "procam/calibrate/result.hpp"
#include "procam/core/base/export.hpp"

namespace procam::analyze {

/// The largest predicted error that the user accepts.
struct AcceptedError {
  /// RMS, millimetres. Markers, localisers and hand-measured maps place a surface to some 5 to 10 mm: below
  /// 5 mm the calibration is not the largest error.
  double rms_mm = 5;
  /// Externally is the larger of the two errors in nearly all rigs, so it is the safe one to check.
  SurfaceLocated located = SurfaceLocated::kExternally;
};

/// Whether the rig's predicted error (RMS) is accepted. Both errors are in its detail. Named "predicted
/// error", after the projector where the rig has several.
PROCAM_EXPORT Gate predicted_error_check(const Rig& rig, const LightErrors& predicted,
                                         const AcceptedError& accepted);

/// The predicted errors of every projector, in the rig's order, on a wall `wall` metres from each; none where
/// the rig has no covariance.
PROCAM_EXPORT std::vector<LightErrors> predicted_errors(const Rig& rig, double wall);

/// Adds the check of each projector's predicted error to `gates`; a failed one to `diagnostics` as well.
PROCAM_EXPORT void check_predicted_errors(const Rig& rig, const std::vector<LightErrors>& predicted,
                                          const AcceptedError& accepted, std::vector<Gate>& gates,
                                          Diagnostics& diagnostics);

/// The same for a calibration: predicts, adds the checks to its rig's quality and its diagnostics, and returns
/// what was predicted.
PROCAM_EXPORT std::vector<LightErrors> check_predicted_errors(calibrate::CalibrationResult& result,
                                                              double wall = 2,
                                                              const AcceptedError& accepted = {});

/// Does the rig fail for its predicted error alone? Then its numbers are sound, and more views make it good.
PROCAM_EXPORT bool only_predicted_error_failed(const RigQuality& quality);

/// "29 mm RMS at 2 m, surface located externally"; of a camera that does not see all of the frame its share.
PROCAM_EXPORT std::string in_words(const LightError& error);

}  // namespace procam::analyze
