#include "describe.hpp"

#include <Eigen/LU>
#include <cmath>
#include <optional>

#include "causes.hpp"
#include "procam/core/base/closed_form.hpp"
#include "procam/core/base/words.hpp"
#include "residual_blocks.hpp"
#include "rig_covariance.hpp"
#include "rig_motion.hpp"
#include "view_variation.hpp"

namespace procam::calibrate {
namespace {

void warn_view_rejected(const std::string& view, const std::string& device, const std::string& cause,
                        std::string& note, Diagnostics& diagnostics) {
  note += (note.empty() ? "" : "; ") + ("rejected for " + device + ": " + cause);
  diagnostics.warn("view_left_out", "view " + view + " rejected for " + device + ": " + cause);
}

/// Squares of residuals, and how many.
struct SquareSum {
  double sum = 0;
  std::size_t count = 0;

  void add(double square) { sum += square, ++count; }
  double rms() const { return count > 0 ? std::sqrt(sum / double(count)) : 0; }
};

/// Views and residuals of a result.
class ResidualList {
 public:
  ResidualList(const Correspondences& data, const Start& start, const Solution& solution,
               CalibrationResult& result)
      : data_(data), start_(start), solution_(solution), state_(solution.bundle.state), result_(result) {}

  void list(const BundleCovariance& covariance) {
    for (std::size_t v = 0; v < data_.views.size(); ++v) {
      ViewResult view;
      view.name = data_.views[v].name;
      view.rig_from_board = state_.rig_from_board[v];
      view.share = covariance.share[v];
      view.rig_from_board_covariance = covariance.rig_from_board[v];
      view.used = start_.view_used[v] && takes_part(solution_.used, v);
      view.note = start_.notes[v];
      for (std::size_t d = 0; d < data_.devices.size(); ++d) list(v, d, view);
      result_.views.push_back(view);
    }
    result_.joint_rms_px = used_.rms();
    result_.joint_rms_all_px = all_.rms();
  }

 private:
  void list(std::size_t v, std::size_t d, ViewResult& view) {
    view.rms_px.push_back(spread_of(data_, state_, solution_.used, int(d), int(v)).rms_px);
    const std::vector<Measurement> measurements = measurements_of(data_, int(v), int(d));
    int dropped = 0;
    if (view.used)
      for (const Measurement& m : measurements) {
        const bool with_camera =
            data_.devices[d].kind == DeviceKind::kProjector && solution_.rejected[v][std::size_t(m.camera())];
        const Residual& residual = result_.residuals.emplace_back(residual_of(m, v, d, with_camera));
        dropped += !residual.used && !with_camera;
      }
    if (solution_.rejected[v][d])
      warn_view_rejected(view.name, data_.devices[d].name,
                         cause_of_disagreement(data_, start_.used, solution_, int(v), int(d)), view.note,
                         result_.diagnostics);
    else if (dropped > 0)
      result_.diagnostics.note("outliers", "view " + view.name + ": " + std::to_string(dropped) + " of " +
                                               std::to_string(measurements.size()) + " points of " +
                                               data_.devices[d].name + " rejected as outliers");
  }

  Residual residual_of(const Measurement& m, std::size_t v, std::size_t d, bool with_camera) {
    Residual residual;
    residual.view = int(v);
    residual.device = int(d);
    residual.point = m.observation != nullptr ? m.observation->point : -1;
    residual.pixel = m.pixel();
    residual.used = solution_.used[v][d][std::size_t(m.index)];
    if (const auto r = reprojection_residual(state_, m)) {
      residual.residual = *r;
      all_.add(r->squaredNorm());
      if (!residual.used) residual.reason = px(r->norm()) + " from its projection";
    } else {
      residual.reason = "behind the lens or beyond its distortion's fold";
    }
    if (const auto judged = judged_residual(state_, m))
      residual.whitened =
          cholesky_lower(solution_.options.noise[d].covariance(judged->covariance)).inverse() *
          judged->residual;
    if (with_camera)
      residual.reason = "read by " + data_.devices[std::size_t(m.camera())].name + ", which was rejected";
    if (residual.used) used_.add(residual.residual.squaredNorm());
    return residual;
  }

  const Correspondences& data_;
  const Start& start_;
  const Solution& solution_;
  const BundleState& state_;
  CalibrationResult& result_;
  SquareSum used_, all_;
};

void tell_image_changes(CalibrationResult& result) {
  for (std::size_t d = 0; d < result.image_changes.size(); ++d) {
    // Less than a part of what the points err by anyway is worth no warning.
    constexpr double kPart = 0.25, kMinPx = 0.03;
    const ImageChange& change = result.image_changes[d];
    if (displacement_px(change, result.devices[d].size) < std::max(kMinPx, kPart * result.rms_px[d]))
      continue;
    std::string by;
    if (change.focus_rms > 0) by = "its focal length by " + percent(change.focus_rms, 2);
    if (change.shift_rms_px > 0)
      by += (by.empty() ? "" : ", ") + ("its principal point by " + px(change.shift_rms_px));
    result.diagnostics.warn(
        "image_changes", result.devices[d].name + "'s image changes from view to view, " + by +
                             " (RMS): autofocus, an image stabiliser, or a mount that gives way. The changes "
                             "are estimated view by view, and the rig has their mean; switch autofocus and "
                             "stabiliser off before the rig is used");
  }
}

}  // namespace

CalibrationResult describe(const Correspondences& data, const Start& start, const Solution& solution,
                           const BundleCovariance& covariance, const std::vector<RigMotion>& motions) {
  const BundleState& state = solution.bundle.state;
  CalibrationResult result;
  result.devices = data.devices;
  result.noise = solution.options.noise;
  result.iterations = solution.bundle.iterations;
  result.converged = solution.bundle.converged;
  result.diagnostics = data.diagnostics;
  result.diagnostics.append(start.diagnostics);
  ResidualList(data, start, solution, result).list(covariance);

  Rig& rig = result.rig = rig_of(data, state);
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    result.rms_px.push_back(spread_of(data, state, solution.used, int(d)).rms_px);
    result.rms_all_px.push_back(spread_of(data, state, start.used, int(d)).rms_px);
    rig.quality.rms_px[data.devices[d].name] = result.rms_px.back();
  }
  for (const ViewResult& view : result.views) rig.quality.views_used += view.used;
  if (!motions.empty())
    result.diagnostics.warn(motions.front().of_lens() ? "lens_changed" : "device_moved",
                            description(motions, data));
  for (std::size_t d = 1; d < data.devices.size(); ++d) {
    if (const auto changed = changed_device(data, start.used, solution, int(d)))
      result.diagnostics.warn(changed->of_lens ? "lens_changed" : "device_moved", changed->description);
    // What a motion leaves in the residuals looks like anything, also like a periodic pattern.
    const std::string resampled = !motions.empty() ? "" : resampled_picture(data, solution, int(d));
    if (!resampled.empty()) result.diagnostics.warn("picture_resampled", resampled);
  }
  result.image_changes = image_change_rms(data, solution);
  tell_image_changes(result);
  return result;
}

}  // namespace procam::calibrate
