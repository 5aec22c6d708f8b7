#pragma once
/// A calibrated session of a numeric world and its report.
#include <string>

#include "procam/calibrate/calibrate.hpp"
#include "procam/report/calibration.hpp"
#include "support/numeric_world.hpp"

namespace procam::test {

struct CalibratedSession {
  Correspondences data;
  calibrate::CalibrationResult result;
  report::ReportInput input;

  std::string page() const { return report::calibration_report(result, data, input); }
};

/// With an outlier of each device, a name that HTML must escape, and the true errors.
inline CalibratedSession calibrate_session(int views, bool holdout) {
  const NumericWorld world = NumericWorld::make(views, 11, 0.08, 0.12);
  CalibratedSession session;
  session.data = world.correspondences(12);
  session.data.views[1].name = R"(<b>&"x")";
  session.data.views[2].observations[0][7].pixel += Vec2(9, -6);
  session.data.views[3].observations[1][20].pixel += Vec2(-14, 3);
  calibrate::Options options;
  options.holdout = holdout;
  session.result = calibrate::calibrate_rig(session.data, options);
  session.input.title = "wall & floor";
  session.input.predicted = {analyze::predicted_light_errors(session.result.rig, 2.0)};
  Rig truth;
  truth.cameras.push_back({"camera", world.camera, Pose()});
  truth.projectors.push_back({"projector", world.projector, world.projector_from_camera.inverse()});
  session.input.truth = {analyze::true_light_errors(session.result.rig, truth, 2.0)};
  session.result.rig.provenance = {
      "calibrate-projector", "0.1.0", "2024-05-06T07:08:09Z", {{"step", "4"}}, {{"a/<1>.png", "00ff"}}};
  return session;
}

/// One solve for all tests that read a good page.
inline const CalibratedSession& calibrated_session() {
  static const CalibratedSession session = calibrate_session(8, true);
  return session;
}

}  // namespace procam::test
