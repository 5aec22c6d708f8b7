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
    gate.detail += ": above the accepted " + shortest(accepted.rms_mm) +
                   " mm; add views, above all the one that is advised as the next";
  return gate;
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
