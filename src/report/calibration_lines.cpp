/// The lines of a console about calibrations.
#include <algorithm>
#include <cmath>

#include "fields.hpp"
#include "procam/core/base/words.hpp"
#include "procam/report/calibration.hpp"

namespace procam::report {
namespace {

using calibrate::CalibrationResult;
using Lines = std::vector<std::string>;

/// "left: " where there are several projectors.
std::string prefix(const Rig& rig, const std::string& projector) {
  return rig.projectors.size() > 1 ? projector + ": " : "";
}

/// "camera 0.123 px, projector 0.098 px": a figure of every device.
std::string each_px(const CalibrationResult& result, const std::vector<double>& px) {
  std::string text;
  for (std::size_t d = 0; d < result.devices.size(); ++d)
    text += (d > 0 ? ", " : "") + format("%s %.3f px", result.devices[d].name.c_str(), px[d]);
  return text;
}

/// Decimals that show two digits of a sigma, one of a number that has none.
int lens_decimals(double sigma) {
  return sigma > 0 ? std::clamp(1 - int(std::floor(std::log10(sigma))), 0, 4) : 1;
}

std::string lens_line(const std::string& device, const Camera& lens, const NamedCovariance& covariance) {
  std::string line = format("%-10s", device.c_str());
  const VecX values = parameters_of(lens);
  const std::vector<std::string> names = parameter_names(lens);
  for (std::size_t i = 0; i < std::min<std::size_t>(names.size(), 4); ++i) {
    const double value = values[Eigen::Index(i)], sigma = covariance.sigma(device + "." + names[i]);
    const int digits = lens_decimals(sigma);
    line += format("  %s %.*f +- %.*f", names[i].c_str(), digits, value, digits, sigma);
  }
  return line + " px";
}

void add_lenses(const Rig& rig, Lines& lines) {
  for (const RigCamera& camera : rig.cameras)
    lines.push_back(lens_line(camera.name, camera.camera, rig.covariance));
  for (const RigProjector& projector : rig.projectors)
    lines.push_back(lens_line(projector.name, projector.projector.inverse_camera, rig.covariance));
}

/// Every parameter, of cameras that are calibrated alone.
void add_parameters(const Rig& rig, Lines& lines) {
  for (const RigCamera& device : rig.cameras) {
    const VecX values = parameters_of(device.camera);
    const std::vector<std::string> names = parameter_names(device.camera);
    if (rig.cameras.size() > 1) lines.push_back(device.name);
    for (std::size_t i = 0; i < names.size(); ++i) {
      const double sigma = rig.covariance.sigma(device.name + "." + names[i]);
      lines.push_back(format("%-6s %12.5f +- %.5f%s", names[i].c_str(), values[Eigen::Index(i)], sigma,
                             sigma > 0 ? "" : "  fixed"));
    }
  }
}

void add_residuals(const CalibrationResult& result, const ReportInput& input, Lines& lines) {
  std::string by_views;
  for (std::size_t d = 0; d < result.devices.size(); ++d)
    by_views += (d > 0 ? ", " : "") + result.devices[d].name + " " +
                std::to_string(device_counts(result, int(d)).views_used);
  lines.push_back(
      format("views      %d of %d used (%s)", result.rig.quality.views_used, input.views, by_views.c_str()));
  lines.push_back("RMS        " + each_px(result, result.rms_px) +
                  format(", joint %.3f px", result.joint_rms_px));
  lines.push_back("           outliers included: " + each_px(result, result.rms_all_px) +
                  format(", joint %.3f px", result.joint_rms_all_px));
  if (result.holdout_px.empty()) return;
  const bool changes = result.diagnostics.find("image_changes") != nullptr;
  lines.push_back("held out   " + each_px(result, result.holdout_px) +
                  "; each view predicted by a solve without it" +
                  (changes ? ", which does not know how its image has changed" : ""));
  lines.push_back("           outliers included: " + each_px(result, result.holdout_all_px));
}

void add_board(const CalibrationResult& result, Lines& lines) {
  if (result.diagnostics.find("board_shape") != nullptr)
    lines.push_back((result.shape.free_points ? format("board      not flat: points %.2f mm along and ",
                                                       1e3 * result.shape.in_plane_rms)
                                              : std::string("board      bent like a sheet: points ")) +
                    format("%.2f mm off its plane (RMS), max %.2f mm", 1e3 * result.shape.out_of_plane_rms,
                           1e3 * result.shape.largest) +
                    (result.shape.largest_of_light > 0
                         ? format(", projected points max %.1f mm", 1e3 * result.shape.largest_of_light)
                         : ""));
  if (result.diagnostics.find("board_flexes") != nullptr)
    lines.push_back(
        format("board      bends anew in each view, by %.2f mm (RMS)", 1e3 * result.shape.flex_rms));
  lines.push_back("measure    " + result.size_to_measure);
}

void add_lens_models(const CalibrationResult& result, Lines& lines) {
  int device = -1;
  for (const calibrate::LensAlternative& one : result.lens_alternatives) {
    if (one.device != device) {
      device = one.device;
      lines.push_back(format("%-31s terms   error on held-out views, px",
                             (result.devices[std::size_t(device)].name + "'s lens").c_str()));
    }
    lines.push_back(format("  %-29s %5d", one.model.c_str(), one.terms) +
                    (one.by_view.empty() ? format("%16s", "") : format("%13.3f   ", one.holdout_px)) +
                    (one.chosen ? "selected" : one.ruled_out));
  }
  // A table whose smallest number is not selected asks for the reason.
  for (const calibrate::LensAlternative& chosen : result.lens_alternatives)
    for (const calibrate::LensAlternative& one : result.lens_alternatives)
      if (chosen.chosen && one.device == chosen.device && one.terms < chosen.terms && one.ruled_out.empty() &&
          !one.by_view.empty() && one.holdout_px < chosen.holdout_px) {
        lines.push_back(
            "           fewer terms are not selected though they predict these views as well: the missing "
            "ones show where no view is");
        return;
      }
}

void add_views(const CalibrationResult& result, const ReportInput& input, Lines& lines) {
  const std::vector<std::string> verdicts = analyze::view_verdicts(result);
  for (std::size_t v = 0; v < verdicts.size(); ++v)
    if (verdicts[v] != "fine")
      lines.push_back(format("view       %s: %s", result.views[v].name.c_str(), verdicts[v].c_str()));
  if (!input.next_view) return;
  const analyze::LightError &now = input.next_view->now.of(input.accepted.located),
                            &then = input.next_view->then.of(input.accepted.located);
  lines.push_back(format("add next   the board %s: predicted error %s -> %s mm (surface located %s)",
                         input.next_view->words.c_str(), significant(now.rms_mm, 2).c_str(),
                         significant(then.rms_mm, 2).c_str(), analyze::to_string(then.located)));
}

void add_truth_lines(const Rig& rig, const ReportInput& input, Lines& lines) {
  if (input.truth.empty()) return;
  for (const analyze::LightErrors& errors : input.truth) {
    const auto add = [&](const analyze::LightError& error) {
      lines.push_back(format("truth      %serror %s (mean %s, max %s mm)",
                             prefix(rig, error.projector).c_str(), analyze::in_words(error).c_str(),
                             significant(error.mean_mm, 2).c_str(), significant(error.worst_mm, 2).c_str()));
    };
    add(errors.externally);
    if (errors.by_camera) add(*errors.by_camera);
  }
  lines.push_back(format("truth      %d of %d parameters inside 3 sigma", input.within_truth.inside_3_sigma,
                         input.within_truth.parameters));
}

/// A tape measure shows whether the unit of a file's translation is right; no check does.
void add_distances(const Rig& rig, Lines& lines) {
  constexpr double kNear = 5e-3;
  if (rig.cameras.empty()) return;
  const RigCamera& camera = rig.cameras.front();
  for (const RigProjector& projector : rig.projectors) {
    const double distance =
        (projector.rig_from_projector.translation - camera.rig_from_camera.translation).norm();
    lines.push_back(format("distance   %s is %s mm from %s: ", projector.name.c_str(),
                           significant(1e3 * distance, 3).c_str(), camera.name.c_str()) +
                    (distance < kNear ? "is the file's translation in another unit (--unit)?"
                                      : "compare it with a tape measure"));
  }
}

void add_gates(const std::vector<Gate>& gates, Lines& lines) {
  int failed = 0;
  for (const Gate& gate : gates) {
    if (gate.passed) continue;
    ++failed;
    lines.push_back("check FAILED " + gate.name + ": " + gate.detail);
  }
  lines.push_back(failed == 0 ? format("checks     all %zu quality checks passed", gates.size())
                              : format("checks     %d of %zu quality checks failed", failed, gates.size()));
}

}  // namespace

Lines headline(const Rig& rig, const RigQuality& quality, const ReportInput& input) {
  const bool imprecise = analyze::only_predicted_error_failed(quality);
  const char* const verdict = quality.passed() ? "passed" : imprecise ? "usable, but" : "do not use";
  if (input.predicted.empty())
    return {format("result     %s; the rig states no uncertainty, so no error is predicted", verdict)};
  Lines lines;
  for (std::size_t i = 0; i < input.predicted.size(); ++i) {
    const analyze::LightErrors& errors = input.predicted[i];
    const analyze::LightError& selected = errors.of(input.accepted.located);
    std::string line = i == 0 ? format("result     %s%s ", verdict, imprecise ? "" : ":") : "           ";
    line += prefix(rig, rig.projectors[i].name) + "predicted error " + analyze::in_words(selected) +
            format(" (accepted: %g mm)", input.accepted.rms_mm);
    if (i + 1 == input.predicted.size() && imprecise)
      line += input.next_view ? ": add the view below" : rig.cameras.empty() ? ": add points" : ": add views";
    lines.push_back(line);
    const analyze::LightError* other = &errors.externally;
    if (selected.located == analyze::SurfaceLocated::kExternally)
      other = errors.by_camera ? &*errors.by_camera : nullptr;
    if (other != nullptr) lines.push_back("           " + analyze::in_words(*other));
    std::string limit = "           with 95 % confidence below " + significant(selected.rms95_mm, 2) + " mm";
    if (other != nullptr)
      limit += ", located " + std::string(analyze::to_string(other->located)) + " below " +
               significant(other->rms95_mm, 2) + " mm";
    lines.push_back(limit);
    if (!errors.by_camera && !rig.cameras.empty())
      lines.push_back("           no camera of the rig sees the frame there, so none can locate the surface");
  }
  return lines;
}

Lines headline(const CalibrationResult& result, const ReportInput& input) {
  const RigQuality& quality = result.rig.quality;
  if (!result.rig.projectors.empty()) return headline(result.rig, quality, input);
  return {format("result     %s: RMS %.3f px (outliers included: %.3f), %d of %d views used",
                 quality.passed() ? "passed" : "do not use", result.joint_rms_px, result.joint_rms_all_px,
                 quality.views_used, input.views)};
}

Lines lines(const CalibrationResult& result, const ReportInput& input) {
  const Rig& rig = result.rig;
  Lines lines;
  if (rig.projectors.empty()) {
    for (std::size_t d = 0; d < result.holdout_px.size(); ++d)
      lines.push_back(format("held out   %s %.3f px; each view predicted by a solve without it",
                             result.devices[d].name.c_str(), result.holdout_px[d]));
    add_parameters(rig, lines);
  } else {
    add_residuals(result, input, lines);
    add_lenses(rig, lines);
  }
  for (const RigProjector& device : rig.projectors)
    lines.push_back(
        format("optics     %sthrow ratio %.2f, lens shift %+.0f %% of the width, %+.0f %% of the height",
               prefix(rig, device.name).c_str(), device.projector.throw_ratio(),
               100 * device.projector.lens_shift().x(), 100 * device.projector.lens_shift().y()));
  add_board(result, lines);
  add_lens_models(result, lines);
  if (!rig.projectors.empty()) add_views(result, input, lines);
  add_truth_lines(rig, input, lines);
  add_gates(rig.quality.gates, lines);
  return lines;
}

Lines lines(const calibrate::PointsResult& result, const std::vector<PointPair>& pairs,
            const ReportInput& input) {
  require(result.pairs.size() == pairs.size(), "lines: result and pairs do not belong together");
  Lines lines;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const calibrate::PairResidual& pair = result.pairs[i];
    lines.push_back(format(
        "%-24s %7.2f %7.2f px%s",
        pairs[i].name.empty() ? format("pair %zu", i + 1).c_str() : pairs[i].name.substr(0, 24).c_str(),
        pair.residual.x(), pair.residual.y(),
        !pair.used          ? "  rejected"
        : pair.loo_residual ? format("  (%.2f when held out)", pair.loo_residual->norm()).c_str()
                            : ""));
  }
  lines.push_back(format("RMS        %.2f px; one coordinate's sigma %.2f px; held out in turn %.2f px",
                         result.rms_px, result.sigma_px, result.loo_rms_px));
  add_lenses(result.rig, lines);
  const Vec3 position = result.rig.projector().rig_from_projector.translation;
  lines.push_back(
      format("place      %.3f, %.3f, %.3f m in the room", position.x(), position.y(), position.z()));
  add_truth_lines(result.rig, input, lines);
  add_gates(result.rig.quality.gates, lines);
  return lines;
}

Lines lines(const calibrate::UpdateResult& result, const ReportInput& input) {
  Lines lines;
  for (const calibrate::DeviceChange& one : result.changes) {
    std::string line = format("changed    %s", one.device.c_str());
    if (one.rotation_sigma > 0)
      line += format(" rotated by %.3f +- %s deg and moved by %.2f +- %s mm", one.rotation / kDegree,
                     significant(one.rotation_sigma / kDegree, 2).c_str(), 1e3 * one.translation,
                     significant(1e3 * one.translation_sigma, 2).c_str());
    if (one.focal_ratio_sigma > 0)
      line += format("%s focal length multiplied by %.5f +- %s", one.rotation_sigma > 0 ? "," : "",
                     one.focal_ratio, significant(one.focal_ratio_sigma, 2).c_str());
    lines.push_back(line);
  }
  for (const calibrate::UpdatedView& view : result.views) {
    std::string line = format("view       %s", view.name.c_str());
    for (std::size_t d = 0; view.used && d < result.devices.size(); ++d)
      if (view.rms_px[d] > 0) line += format("  %s %.3f px", result.devices[d].name.c_str(), view.rms_px[d]);
    lines.push_back(line + (view.used ? "" : "  rejected"));
  }
  add_lenses(result.rig, lines);
  add_truth_lines(result.rig, input, lines);
  add_gates(result.rig.quality.gates, lines);
  return lines;
}

Lines lines(const Rig& rig, const RigQuality& quality) {
  Lines lines;
  add_lenses(rig, lines);
  add_distances(rig, lines);
  add_gates(quality.gates, lines);
  return lines;
}

}  // namespace procam::report
