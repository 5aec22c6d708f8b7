#include <algorithm>
#include <set>

#include "procam/report/calibration.hpp"

namespace procam::report {

DeviceCounts device_counts(const calibrate::CalibrationResult& result, int device) {
  DeviceCounts counts;
  std::set<int> views;
  for (const calibrate::Residual& residual : result.residuals) {
    if (residual.device != device) continue;
    ++counts.points_found;
    if (!residual.used) continue;
    ++counts.points_used;
    views.insert(residual.view);
  }
  counts.views_used = int(views.size());
  return counts;
}

ReportInput judge(const Rig& rig, double wall, const analyze::AcceptedError& accepted,
                  std::vector<Gate>& gates, Diagnostics& diagnostics) {
  ReportInput input;
  input.wall = wall;
  input.accepted = accepted;
  input.predicted = analyze::predicted_errors(rig, wall);
  analyze::check_predicted_errors(rig, input.predicted, accepted, gates, diagnostics);
  return input;
}

ReportInput judge(calibrate::CalibrationResult& result, double wall, const analyze::AcceptedError& accepted,
                  const std::optional<Rig>& truth) {
  Rig& rig = result.rig;
  ReportInput input = judge(rig, wall, accepted, rig.quality.gates, result.diagnostics);
  const auto worst =
      std::max_element(input.predicted.begin(), input.predicted.end(), [&](const auto& a, const auto& b) {
        return a.of(accepted.located).rms_mm < b.of(accepted.located).rms_mm;
      });
  if (worst != input.predicted.end())
    input.next_view = analyze::advise_next_view(result, wall, worst->externally.projector, accepted.located);
  if (truth) add_truth(rig, *truth, input);
  return input;
}

void add_truth(const Rig& rig, const Rig& truth, ReportInput& input) {
  for (const RigProjector& projector : rig.projectors)
    input.truth.push_back(
        analyze::true_light_errors(rig, truth, input.wall, rig.projectors.size() > 1 ? projector.name : ""));
  input.within_truth = analyze::parameters_within_truth(rig, truth);
}

}  // namespace procam::report
