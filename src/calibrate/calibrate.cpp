#include "procam/calibrate/calibrate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "causes.hpp"
#include "joined.hpp"
#include "lens_choice.hpp"
#include "observability.hpp"
#include "procam/calibrate/bundle.hpp"
#include "procam/calibrate/gates.hpp"
#include "procam/calibrate/uncertainty.hpp"
#include "rig_covariance.hpp"
#include "shape.hpp"
#include "solve.hpp"
#include "start.hpp"

namespace procam::calibrate {
namespace {

std::string px(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f px", value);
  return text;
}

std::string times(double factor) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f times", factor);
  return text;
}

void report(const Options& options, const std::string& step, double share) {
  if (options.progress) options.progress(step, share);
}

void require_consistent(const Correspondences& data) {
  require(!data.devices.empty() && data.devices.front().kind == DeviceKind::kCamera,
          "calibrate: the first device must be a camera");
  const int num_points = int(points_in_board(data.board).size());
  for (const View& view : data.views) {
    require(view.observations.size() == data.devices.size(),
            "calibrate: view '" + view.name + "' must have one list of observations a device");
    const auto is_a = [&](int device, DeviceKind kind) {
      return device >= 0 && device < int(data.devices.size()) &&
             data.devices[std::size_t(device)].kind == kind;
    };
    for (std::size_t d = 0; d < data.devices.size(); ++d)
      for (const Observation& o : view.observations[d]) {
        require(
            o.point >= 0 && o.point < num_points && o.pixel.allFinite() && o.covariance.allFinite() &&
                o.covariance.determinant() > 0,
            "calibrate: view '" + view.name + "' has an observation that is not finite or not of this board");
        require(data.devices[d].kind == DeviceKind::kCamera || is_a(o.camera, DeviceKind::kCamera),
                "calibrate: view '" + view.name + "' has a projector's pixel that no camera read");
      }
    for (const LightPoint& light : view.light_points) {
      require(
          is_a(light.projector, DeviceKind::kProjector) && is_a(light.camera, DeviceKind::kCamera) &&
              light.projector_pixel.allFinite() && light.camera_pixel.allFinite() &&
              light.camera_covariance.allFinite() && light.camera_covariance.determinant() > 0,
          "calibrate: view '" + view.name + "' has a light point that is not finite or of no such devices");
    }
  }
}

/// Error of each device on a view that the solve did not see, its board pose taken from its first camera
/// alone.
void hold_out(const Correspondences& data, const UsedMask& everything, const Solution& full, int view,
              ViewResult& result) {
  UsedMask without = full.used;
  for (auto& of_device : without[std::size_t(view)]) std::fill(of_device.begin(), of_device.end(), char(0));
  const UsedMask only =
      only_view(full.used, std::size_t(view), posing_camera(data, full.used, std::size_t(view)));
  BundleState state = bundle_adjust(data, without, full.state(), full.options).state;
  state = bundle_adjust(data, only, state, hold_devices(full.options, state)).state;
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    result.holdout_px.push_back(spread_of(data, state, full.used, int(d), view).rms_px);
    result.holdout_all_px.push_back(spread_of(data, state, everything, int(d), view).rms_px);
  }
}

/// The board as printed, or as the views see it.
struct ShapedSolution {
  Correspondences data;  ///< the order of symmetric boards settled
  Solution solution;
  EstimatedShape shape;
  std::vector<int> turned;  ///< views whose order the shape settled
};

/// How much better views must be predicted before 3 numbers a board point are worth their freedom.
constexpr double kShapeGain = 0.95;
/// And by how many standard errors the shape must explain more than noise: with few views, most of them may
/// be predicted better by chance. Flat boards in numbers came to 3 at most, bent ones to 17 at least.
constexpr double kShapeSigmas = 5;
constexpr int kViewsForShape = 4;

ShapedSolution solve_with_shape(const Correspondences& data, const Start& start, const Options& options) {
  ShapedSolution flat{
      data, solve(data, start.state, start.bundle_options, start.first, start.used, options), {}, {}};
  const int views = int(std::count(start.view_used.begin(), start.view_used.end(), true));
  // Where the detectors' own covariances explain every residual, nothing is left for a shape to explain.
  bool unexplained = false;
  for (const ResidualNoise& noise : flat.solution.options.noise) unexplained |= noise.floor_px > 0;
  const bool worth_it = views >= kViewsForShape && unexplained;
  if (options.board_shape == BoardShape::kFlat || (options.board_shape == BoardShape::kAuto && !worth_it))
    return flat;

  report(options, "the board's shape", 0.5);
  ShapedSolution free{data, {}, {}, {}};
  BundleState state = flat.solution.state();
  free.turned = settle_order_by_shape(free.data, flat.solution.used, state, flat.solution.options);
  BundleOptions with_shape = flat.solution.options;
  with_shape.board_sigma = board_sigma(points_in_board(data.board));
  // From all points again: those that the flat board left out are the ones that tell the shape.
  free.solution = solve(free.data, state, with_shape, start.first, start.used, options);
  free.shape = measure_shape(points_in_board(data.board), free.solution.state().points_in_board);

  UsedMask judged = free.solution.used;
  for (std::size_t v = 0; v < judged.size(); ++v)
    for (std::size_t d = 0; d < judged[v].size(); ++d)
      for (std::size_t i = 0; i < judged[v][d].size(); ++i)
        judged[v][d][i] = judged[v][d][i] || flat.solution.used[v][d][i];
  const auto flat_error =
      predicted_holdout(data, flat.solution.used, judged, flat.solution.state(), flat.solution.options);
  const auto free_error =
      predicted_holdout(free.data, free.solution.used, judged, free.solution.state(), free.solution.options);
  const bool better = flat_error && free_error && *free_error < kShapeGain * *flat_error &&
                      explained_by_shape(data, flat.solution, free.data, free.solution) > kShapeSigmas;
  ShapedSolution& chosen = better || options.board_shape == BoardShape::kFree ? free : flat;
  chosen.shape.holdout_flat_px = flat_error.value_or(0);
  chosen.shape.holdout_free_px = free_error.value_or(0);
  return chosen;
}

void left_out_of_view(const std::string& view, const std::string& device, const std::string& cause,
                      std::string& note, Diagnostics& diagnostics) {
  note += (note.empty() ? "" : "; ") + ("left out for " + device + ": " + cause);
  diagnostics.warn("view_left_out", "view " + view + " left out for " + device + ": " + cause);
}

CalibrationResult describe(const Correspondences& data, const Start& start, const Solution& solution,
                           const BundleCovariance& covariance) {
  const BundleState& state = solution.bundle.state;
  CalibrationResult result;
  result.devices = data.devices;
  result.noise = solution.options.noise;
  result.iterations = solution.bundle.iterations;
  result.converged = solution.bundle.converged;
  result.diagnostics = data.diagnostics;
  result.diagnostics.append(start.diagnostics);

  double joint_sum = 0, joint_sum_all = 0;
  std::size_t joint_count = 0, joint_count_all = 0;
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    ViewResult view;
    view.name = data.views[v].name;
    view.rig_from_board = state.rig_from_board[v];
    view.share = covariance.share[v];
    view.rig_from_board_covariance = covariance.rig_from_board[v];
    view.used = start.view_used[v] && takes_part(solution.used, v);
    view.note = start.notes[v];
    for (std::size_t d = 0; d < data.devices.size(); ++d) {
      view.rms_px.push_back(spread_of(data, state, solution.used, int(d), int(v)).rms_px);
      const std::vector<Measurement> measurements = measurements_of(data, int(v), int(d));
      int dropped = 0;
      for (const Measurement& m : measurements) {
        if (!view.used) break;
        Residual residual;
        residual.view = int(v);
        residual.device = int(d);
        residual.point = m.observation != nullptr ? m.observation->point : -1;
        residual.pixel = m.pixel();
        residual.used = solution.used[v][d][std::size_t(m.index)];
        if (const auto r = reprojection_residual(state, m)) {
          residual.residual = *r;
          joint_sum_all += r->squaredNorm();
          ++joint_count_all;
          if (!residual.used) residual.reason = px(r->norm()) + " from its projection";
        } else {
          residual.reason = "behind the lens or beyond its distortion's fold";
        }
        const bool with_camera =
            data.devices[d].kind == DeviceKind::kProjector && solution.left_out[v][std::size_t(m.camera())];
        if (with_camera)
          residual.reason = "read by " + data.devices[std::size_t(m.camera())].name + ", which was left out";
        if (residual.used) {
          joint_sum += residual.residual.squaredNorm();
          ++joint_count;
        } else if (!with_camera) {
          ++dropped;
        }
        result.residuals.push_back(residual);
      }
      const std::string of_device = " of " + data.devices[d].name;
      if (solution.left_out[v][d])
        left_out_of_view(view.name, data.devices[d].name,
                         cause_of_disagreement(data, start.used, solution, int(v), int(d)), view.note,
                         result.diagnostics);
      else if (dropped > 0)
        result.diagnostics.note("outliers", "view " + view.name + ": " + std::to_string(dropped) + " of " +
                                                std::to_string(measurements.size()) + " points" + of_device +
                                                " left out as outliers");
    }
    result.views.push_back(view);
  }
  result.joint_rms_px = joint_count > 0 ? std::sqrt(joint_sum / double(joint_count)) : 0;
  result.joint_rms_all_px = joint_count_all > 0 ? std::sqrt(joint_sum_all / double(joint_count_all)) : 0;

  Rig& rig = result.rig = rig_of(data, state);
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    result.rms_px.push_back(spread_of(data, state, solution.used, int(d)).rms_px);
    result.rms_all_px.push_back(spread_of(data, state, start.used, int(d)).rms_px);
    rig.quality.rms_px[data.devices[d].name] = result.rms_px.back();
  }
  for (const ViewResult& view : result.views) rig.quality.views_used += view.used;
  for (std::size_t d = 1; d < data.devices.size(); ++d) {
    const std::string moved = moved_device(data, start.used, solution, int(d));
    if (!moved.empty()) result.diagnostics.warn("device_moved", moved);
    const std::string resampled = resampled_picture(data, solution, int(d));
    if (!resampled.empty()) result.diagnostics.warn("picture_resampled", resampled);
  }
  return result;
}

std::string millimetres(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f mm", 1e3 * metres);
  return text;
}

void tell_shape(const ShapedSolution& shaped, CalibrationResult& result) {
  const EstimatedShape& shape = shaped.shape;
  result.shape = shape;
  for (const int v : shaped.turned)
    if (shape.free) {
      std::string& note = result.views[std::size_t(v)].note;
      note +=
          (note.empty() ? "" : "; ") + std::string("order turned by 180 degrees, as the board's shape asked");
    }
  if (shape.free)
    result.diagnostics.note("board_shape",
                            "the board is not flat: its points lie " + millimetres(shape.in_plane_rms) +
                                " along and " + millimetres(shape.out_of_plane_rms) +
                                " off its plane (RMS), max " + millimetres(shape.largest) +
                                "; modelling the board's shape reduces the held-out error from " +
                                px(shape.holdout_flat_px) + " to " + px(shape.holdout_free_px));
}

/// When half of the views say otherwise, nobody knows which half is right.
Gate agreement_gate(const Correspondences& data, const Start& start, const Solution& solution) {
  Gate gate{"views agree", true, "all"};
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    int left_out = 0, views = 0;
    for (std::size_t v = 0; v < data.views.size(); ++v) {
      if (count_used(start.used, v, d) == 0) continue;
      ++views;
      left_out += count_used(solution.used, v, d) == 0;
    }
    if (left_out == 0) continue;
    const std::string count = std::to_string(left_out) + " of " + std::to_string(views) +
                              " views disagree about " + data.devices[d].name;
    gate.passed = gate.passed && 2 * left_out < views;
    gate.detail = gate.detail == "all" ? count : gate.detail + ", " + count;
  }
  if (!gate.passed) gate.detail += ": capture again what the remarks name";
  return gate;
}

/// A board that is bent by more than a few sigmas of what a printed sheet does is no board to calibrate with.
constexpr double kLargestBend = 5;

Gate shape_gate(const Correspondences& data, const EstimatedShape& shape) {
  const double limit = kLargestBend * board_sigma(points_in_board(data.board));
  const bool passed = shape.largest <= limit;
  return {
      "board's shape", passed,
      "largest offset " + millimetres(shape.largest) +
          (passed ? ""
                  : ", limit " + millimetres(limit) +
                        ": mount the sheet on a stiff flat plate, and check the square's size both ways")};
}

int agreeing_views(const Start& start, const Solution& solution) {
  int views = 0;
  for (std::size_t v = 0; v < start.view_used.size(); ++v)
    views += start.view_used[v] && takes_part(solution.used, v);
  return views;
}

/// What is known of the devices: by the normal equations, and to be told.
struct Sigmas {
  BundleCovariance formal;
  HonestCovariance honest;
};

Sigmas sigmas_of(const ShapedSolution& shaped, const Start& start) {
  const Solution& solution = shaped.solution;
  BundleUncertainty both = bundle_uncertainty(shaped.data, solution.used, solution.state(), solution.options);
  Sigmas sigmas;
  sigmas.honest = honest_covariance(both.formal.devices, both.jackknife, agreeing_views(start, solution));
  sigmas.formal = std::move(both.formal);
  return sigmas;
}

/// The next solve begins where this one ended, with its lenses and what it holds, on the board as printed.
void begin_again(const Solution& solution, Start& start) {
  const Points3 printed = start.state.points_in_board;
  start.state = solution.state();
  start.state.points_in_board = printed;
  start.first = solution.used;
  start.bundle_options.held = solution.options.held;
  start.bundle_options.priors = solution.options.priors;
}

/// Distortion that the views say little about would be noise, and the light's error between and beyond them:
/// it gets what is known of any lens as a prior, and all is solved again. Returns everything hardly known:
/// what the prior holds, and what else is left open by the sigmas that are told.
std::vector<HardlyKnown> hold_near_prior(ShapedSolution& shaped, Sigmas& sigmas, Start& start,
                                         const Options& options) {
  std::vector<HardlyKnown> all;
  for (HardlyKnown& parameter : hardly_known(shaped.solution, shaped.data, sigmas.formal.devices)) {
    if (!parameter.distortion) continue;
    parameter.at_prior = true;
    all.push_back(std::move(parameter));
  }
  if (!all.empty()) {
    begin_again(shaped.solution, start);
    start.bundle_options.priors.resize(shaped.data.devices.size());
    for (const HardlyKnown& parameter : all)
      start.bundle_options.priors[std::size_t(parameter.device)].push_back(parameter.beforehand);
    shaped = solve_with_shape(shaped.data, start, options);
    sigmas = sigmas_of(shaped, start);
  }
  const std::size_t held = all.size();
  for (const HardlyKnown& parameter : hardly_known(shaped.solution, shaped.data, sigmas.honest.devices))
    if (std::none_of(all.begin(), all.begin() + long(held), [&](const HardlyKnown& other) {
          return other.device == parameter.device && other.parameter == parameter.parameter;
        }))
      all.push_back(parameter);
  return all;
}

void tell_lenses(std::vector<LensAlternative> alternatives, CalibrationResult& result) {
  for (const LensAlternative& alternative : alternatives) {
    if (!alternative.chosen || alternative.model == kUsualLensModel) continue;
    const auto usual = std::find_if(alternatives.begin(), alternatives.end(), [&](const LensAlternative& a) {
      return a.device == alternative.device && a.model == kUsualLensModel;
    });
    result.diagnostics.note("lens_model", result.devices[std::size_t(alternative.device)].name +
                                              "'s lens is taken as " + alternative.model +
                                              ": it predicts views left out to " +
                                              px(alternative.holdout_px) + ", the usual " + kUsualLensModel +
                                              " to " + px(usual->holdout_px));
  }
  result.lens_alternatives = std::move(alternatives);
}

CalibrationResult run(const Correspondences& given, const std::optional<KnownLens>& known_camera,
                      const Options& options) {
  require_consistent(given);
  Correspondences ordered = given;
  Start start = find_start(ordered, known_camera, options);  // settles the order of symmetric boards
  ShapedSolution shaped = solve_with_shape(ordered, start, options);
  Solution chosen;
  std::vector<LensAlternative> alternatives =
      choose_lenses(shaped.data, start.used, shaped.solution, options, known_camera.has_value(), chosen);
  if (chosen.options.held != shaped.solution.options.held) {
    begin_again(chosen, start);
    shaped = solve_with_shape(shaped.data, start, options);
  }
  report(options, "covariance", 0.75);
  Sigmas sigmas = sigmas_of(shaped, start);
  const std::vector<HardlyKnown> open = hold_near_prior(shaped, sigmas, start, options);
  const Correspondences& data = shaped.data;
  const Solution& solution = shaped.solution;
  CalibrationResult result = describe(data, start, solution, sigmas.formal);
  result.solved = {data, solution.used, solution.state(), solution.options};
  result.rig.covariance = rig_covariance(sigmas.honest.devices, data, solution.state());
  result.variance_ratio = sigmas.honest.variance_ratio;
  result.sigmas_from_views = sigmas.honest.inflated;
  if (result.sigmas_from_views)
    result.diagnostics.note(
        "sigmas_from_views",
        "views disagree " + times(std::sqrt(result.variance_ratio)) +
            " more than detection noise predicts; uncertainties are from a leave-one-view-out jackknife");
  tell_lenses(std::move(alternatives), result);
  for (const std::string& sentence : in_words(open, data)) result.diagnostics.warn("hardly_known", sentence);
  tell_shape(shaped, result);

  if (options.holdout) {
    std::vector<int> counted(data.devices.size(), 0);
    result.holdout_px.assign(data.devices.size(), 0);
    result.holdout_all_px.assign(data.devices.size(), 0);
    for (std::size_t v = 0; v < data.views.size(); ++v) {
      ViewResult& view = result.views[v];
      if (!view.used) continue;
      report(options, "leaving out view " + data.views[v].name,
             0.8 + 0.2 * double(v) / double(data.views.size()));
      hold_out(data, start.used, solution, int(v), view);
      for (std::size_t d = 0; d < data.devices.size(); ++d) {
        if (spread_of(data, solution.state(), solution.used, int(d), int(v)).count == 0) continue;
        ++counted[d];
        result.holdout_px[d] += view.holdout_px[d];
        result.holdout_all_px[d] += view.holdout_all_px[d];
      }
    }
    for (std::size_t d = 0; d < data.devices.size(); ++d) {
      result.holdout_px[d] /= std::max(counted[d], 1);
      result.holdout_all_px[d] /= std::max(counted[d], 1);
    }
    for (std::size_t d = 0; d < data.devices.size(); ++d)
      result.rig.quality.holdout_px[data.devices[d].name] = result.holdout_px[d];
  }

  result.rig.quality.gates = check_rig(result.rig);
  int behind = 0;  // the board's printed side faces away from the camera: a mirrored order of corners
  for (const ViewResult& view : result.views)
    if (view.used && view.rig_from_board.rotate(Vec3::UnitZ()).dot(view.rig_from_board.translation) <= 0)
      ++behind;
  result.rig.quality.gates.push_back(
      {"boards face the camera", behind == 0,
       behind == 0 ? "all"
                   : std::to_string(behind) +
                         " seen from behind: the order of their corners is mirrored; do not flip images"});
  result.rig.quality.gates.push_back(agreement_gate(data, start, solution));
  if (shaped.shape.free) result.rig.quality.gates.push_back(shape_gate(data, shaped.shape));
  for (const Gate& gate : result.rig.quality.gates)
    if (!gate.passed) result.diagnostics.fail("gate_failed", gate.name + ": " + gate.detail);
  report(options, "done", 1);
  return result;
}

}  // namespace

CalibrationResult calibrate_camera(const Correspondences& given, const Options& options) {
  require_consistent(given);
  Correspondences cameras;
  cameras.board = given.board;
  cameras.diagnostics = given.diagnostics;
  for (const View& view : given.views) cameras.views.push_back({view.name, {}});
  for (std::size_t d = 0; d < given.devices.size(); ++d) {
    if (given.devices[d].kind != DeviceKind::kCamera) continue;
    cameras.devices.push_back(given.devices[d]);
    for (std::size_t v = 0; v < given.views.size(); ++v)
      cameras.views[v].observations.push_back(given.views[v].observations[d]);
  }
  return run(cameras, std::nullopt, options);
}

CalibrationResult calibrate_projector(const Correspondences& data, const KnownLens& known_camera,
                                      const Options& options) {
  require_consistent(data);
  require(known_camera.lens.size == data.devices.front().size,
          "calibrate_projector: the known camera has another image size");
  return run(data, known_camera, options);
}

CalibrationResult calibrate_rig(const Correspondences& data, const Options& options) {
  return run(data, std::nullopt, options);
}

}  // namespace procam::calibrate
