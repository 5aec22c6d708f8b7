#include "procam/analyze/accept.hpp"

#include "procam/core/base/words.hpp"

namespace procam::analyze {
namespace {

const std::string kCheckName = "predicted error";

bool is_predicted_error(const Gate& gate) {
  return gate.name.size() >= kCheckName.size() &&
         gate.name.compare(gate.name.size() - kCheckName.size(), kCheckName.size(), kCheckName) == 0;
}

}  // namespace

std::string in_words(const LightError& error) {
  const std::string words = significant(error.rms_mm, 2) + " mm RMS at " + shortest(error.distance) +
                            " m, surface located " + to_string(error.located);
  if (!(error.share < 1)) return words;
  return words + ", over the " + fixed(100 * error.share, 0) + " % of the frame that it sees";
}

Gate predicted_error_check(const Rig& rig, const LightErrors& predicted, const AcceptedError& accepted) {
  const LightError& error = predicted.of(accepted.located);
  const LightError* const other = !predicted.by_camera                           ? nullptr
                                  : error.located == SurfaceLocated::kExternally ? &*predicted.by_camera
                                                                                 : &predicted.externally;
  // Written so that NaN fails.
  const bool passed = error.rms_mm <= accepted.rms_mm;
  Gate gate{(rig.projectors.size() > 1 ? error.projector + " " : "") + kCheckName, passed, in_words(error)};
  if (other != nullptr)
    gate.detail +=
        std::string("; ") + significant(other->rms_mm, 2) + " mm located " + to_string(other->located);
  if (error.located != accepted.located) gate.detail += " (no camera of the rig sees the picture there)";
  if (!passed)
    gate.detail += ": above the accepted " + shortest(accepted.rms_mm) + " mm; " +
                   (rig.cameras.empty() ? "add points, at other depths and towards the corners of the frame"
                                        : "add views, above all the one that is advised as the next");
  return gate;
}

std::vector<LightErrors> predicted_errors(const Rig& rig, double wall) {
  std::vector<LightErrors> errors;
  for (const RigProjector& projector : rig.projectors) {
    if (!rig.covariance.index_of(projector.name + ".fx")) return {};
    errors.push_back(predicted_light_errors(rig, wall, projector.name));
  }
  return errors;
}

void check_predicted_errors(const Rig& rig, const std::vector<LightErrors>& predicted,
                            const AcceptedError& accepted, std::vector<Gate>& gates,
                            Diagnostics& diagnostics) {
  for (const LightErrors& errors : predicted) {
    gates.push_back(predicted_error_check(rig, errors, accepted));
    if (!gates.back().passed) diagnostics.fail("gate_failed", gates.back().name + ": " + gates.back().detail);
  }
}

std::vector<LightErrors> check_predicted_errors(calibrate::CalibrationResult& result, double wall,
                                                const AcceptedError& accepted) {
  std::vector<LightErrors> predicted = predicted_errors(result.rig, wall);
  check_predicted_errors(result.rig, predicted, accepted, result.rig.quality.gates, result.diagnostics);
  return predicted;
}

bool only_predicted_error_failed(const RigQuality& quality) {
  bool failed = false;
  for (const Gate& gate : quality.gates) {
    if (gate.passed) continue;
    if (!is_predicted_error(gate)) return false;
    failed = true;
  }
  return failed;
}

}  // namespace procam::analyze
