#include "procam/calibrate/calibrate.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "causes.hpp"
#include "describe.hpp"
#include "hold_out.hpp"
#include "joined.hpp"
#include "known_lens.hpp"
#include "lens_choice.hpp"
#include "lens_models.hpp"
#include "normal_equations.hpp"
#include "observability.hpp"
#include "pose_groups.hpp"
#include "printed_size.hpp"
#include "prior_terms.hpp"
#include "procam/calibrate/bundle.hpp"
#include "procam/calibrate/gates.hpp"
#include "procam/core/base/words.hpp"
#include "residual_blocks.hpp"
#include "residual_distortion.hpp"
#include "result_gates.hpp"
#include "rig_covariance.hpp"
#include "shape.hpp"
#include "shape_choice.hpp"
#include "solve.hpp"
#include "start.hpp"
#include "term_averaging.hpp"
#include "uncertainty.hpp"

namespace procam::calibrate {
namespace {

std::string times(double factor) {
  return format("%.1f times", factor);
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

void tell_shape(const ShapedSolution& shaped, CalibrationResult& result) {
  const EstimatedShape& shape = shaped.shape;
  result.shape = shape;
  for (const int v : shaped.turned)
    if (shape.free) {
      std::string& note = result.views[std::size_t(v)].note;
      note +=
          (note.empty() ? "" : "; ") + std::string("order turned by 180 degrees, as the board's shape asked");
    }
  const Points3 printed = points_in_board(shaped.data.board);
  const bool bends = bends_visibly(shape, printed);
  if (bends)
    result.diagnostics.note(
        "board_shape",
        (shape.free_points ? "the board is not flat: its points lie " + mm(shape.in_plane_rms) + " along and "
                           : "the board is bent like a sheet: its points lie ") +
            mm(shape.out_of_plane_rms) + " off its plane (RMS), max " + mm(shape.largest) +
            (shape.largest_of_light > 0 ? ", projected points max " + mm(shape.largest_of_light) : "") +
            "; modelling the board's shape reduces the held-out error from " + px(shape.holdout_flat_px) +
            " to " + px(shape.holdout_free_px));
  // A printer that fits a sheet to the page scales its sides differently: at least one is not as long as stated.
  constexpr double kStretched = 3e-3;
  const double stretch = shape.stretch_x_over_y;
  if (shape.free_points && std::abs(stretch) > kStretched)
    result.diagnostics.warn(
        "print_stretched",
        "the print is " + format("%.1f %%", 100 * std::abs(stretch)) + " longer along its " +
            (stretch > 0 ? "x than along its y" : "y than along its x") +
            ", by what was stated: it was scaled when it was printed, and distances are wrong by up to as much; measure "
            "both of its sides, print it again at 100 %, or state its true size");
  if (flexes_visibly(shape, printed))
    result.diagnostics.note(
        "board_flexes", "the board bends anew in each view, by " + mm(shape.flex_rms) +
                            " (RMS): the bend of each view is estimated" +
                            (bends || !(shape.holdout_free_px < shape.holdout_flat_px)
                                 ? std::string()
                                 : ", which reduces the held-out error from " + px(shape.holdout_flat_px) +
                                       " to " + px(shape.holdout_free_px)));
}

/// What is known of the devices: by the normal equations, and to be told.
struct Sigmas {
  BundleCovariance formal;
  RobustCovariance robust;
};

Sigmas sigmas_of(const ShapedSolution& shaped, const ResidualDistortionEstimate& beyond) {
  const Solution& solution = shaped.solution;
  BundleUncertainty both = bundle_uncertainty(shaped.data, solution.used, solution.state(), solution.options);
  Sigmas sigmas;
  sigmas.robust = robust_covariance(both.formal.devices, both.jackknife,
                                    count_groups(solution.used, solution.options.pose_groups));
  if (beyond.any())
    for (NamedCovariance* covariance : {&sigmas.robust.devices, &both.formal.devices})
      covariance->matrix += beyond.added_covariance;
  sigmas.formal = std::move(both.formal);
  return sigmas;
}

/// The next solve begins where this one ended, with its lenses and what it holds, on the board as printed.
void begin_again(const Solution& solution, Start& start) {
  const Points3 printed = start.state.points_in_board;
  start.state = solution.state();
  start.state.points_in_board = printed;
  start.state.sheet = flat_sheet(printed);
  start.state.flex.clear();
  start.state.image_changes.clear();
  start.variation = solution.options.variation;
  start.first = solution.used;
  start.bundle_options.held = solution.options.held;
  start.bundle_options.priors = solution.options.priors;
}

/// What the user knows of a lens, and what is known of any; of the latter the variance over `weight`.
std::vector<LensPrior> lens_priors(const LensOptions& of_user, const Camera& lens, double weight) {
  std::vector<LensPrior> priors = of_user.priors;
  for (LensPrior& prior : known_of_any_lens(lens)) {
    prior.sigma /= std::sqrt(weight);
    priors.push_back(std::move(prior));
  }
  return priors;
}

/// From what find_start left to what is to be solved for: `options` decides what is fixed, and every lens
/// that is not known gets what is known of any.
void free_lenses(const Correspondences& data, const Options& options, bool camera_known, Start& start) {
  start.bundle_options.priors.resize(data.devices.size());
  for (std::size_t d = camera_known ? 1 : 0; d < data.devices.size(); ++d) {
    const LensOptions& lens =
        data.devices[d].kind == DeviceKind::kCamera ? options.camera : options.projector;
    start.bundle_options.held[d] = lens.held;
    start.bundle_options.priors[d] = lens_priors(lens, start.state.lenses[d], 1);
  }
}

/// Distortion that the views say little about would be noise, and the light's error between and beyond
/// them: what is known of any lens keeps it near zero. Where the residuals of the views exceed their
/// noise, they say less than the normal equations take them to say, by variance_ratio, and the priors
/// weigh as much more; radial terms of a rational lens get theirs only here. Returns all parameters that
/// are poorly constrained: distortion kept by its prior, and what else the reported sigmas leave open.
std::vector<WeaklyObservable> regularise_weak_parameters(ShapedSolution& shaped, Sigmas& sigmas, Start& start,
                                                         const ResidualDistortionEstimate& beyond,
                                                         bool camera_known, const Options& options) {
  std::vector<WeaklyObservable> all;
  bool again = false;
  for (WeaklyObservable& parameter : weakly_observable(shaped.solution, shaped.data, sigmas.robust.devices)) {
    if (!parameter.distortion || (camera_known && parameter.device == 0)) continue;
    parameter.at_prior = true;
    again |= sigmas.robust.inflated ||
             std::holds_alternative<RationalDistortion>(
                 shaped.solution.state().lenses[std::size_t(parameter.device)].distortion);
    all.push_back(std::move(parameter));
  }
  if (again) {
    begin_again(shaped.solution, start);
    const double weight = sigmas.robust.inflated ? sigmas.robust.variance_ratio : 1;
    for (std::size_t d = camera_known ? 1 : 0; d < shaped.data.devices.size(); ++d)
      start.bundle_options.priors[d] =
          lens_priors(shaped.data.devices[d].kind == DeviceKind::kCamera ? options.camera : options.projector,
                      start.state.lenses[d], weight);
    for (const WeaklyObservable& parameter : all) {
      const auto d = std::size_t(parameter.device);
      if (std::holds_alternative<RationalDistortion>(start.state.lenses[d].distortion))
        start.bundle_options.priors[d].push_back(parameter.beforehand);
    }
    shaped = solve_with_shape(shaped.data, start, options);
    sigmas = sigmas_of(shaped, beyond);
  }
  const std::size_t held = all.size();
  for (const WeaklyObservable& parameter :
       weakly_observable(shaped.solution, shaped.data, sigmas.robust.devices))
    if (std::none_of(all.begin(), all.begin() + long(held), [&](const WeaklyObservable& other) {
          return other.device == parameter.device && other.parameter == parameter.parameter;
        }))
      all.push_back(parameter);
  return all;
}

/// The usual models instead of others that were chosen.
void reject_chosen(std::vector<LensAlternative>& alternatives, const std::string& why) {
  for (LensAlternative& one : alternatives) {
    if (one.chosen && one.model != kUsualLensModel) one.ruled_out = why;
    one.chosen = one.model == kUsualLensModel;
  }
}

void tell_lenses(std::vector<LensAlternative> alternatives, CalibrationResult& result) {
  for (const LensAlternative& alternative : alternatives) {
    if (!alternative.chosen || alternative.model == kUsualLensModel) continue;
    const auto usual = std::find_if(alternatives.begin(), alternatives.end(), [&](const LensAlternative& a) {
      return a.device == alternative.device && a.model == kUsualLensModel;
    });
    result.diagnostics.note("lens_model", result.devices[std::size_t(alternative.device)].name +
                                              "'s lens is taken as " + alternative.model +
                                              ": it predicts held-out views to " +
                                              px(alternative.holdout_px) + ", the usual " + kUsualLensModel +
                                              " to " + px(usual->holdout_px));
  }
  result.lens_alternatives = std::move(alternatives);
}

/// Solved with the lens models that predict held-out views best.
struct ChosenSolution {
  Start start;
  ShapedSolution shaped;
  std::vector<LensAlternative> alternatives;
};

/// `variation`: as an earlier solve had it, or none.
ChosenSolution solve_with_chosen_lenses(const Correspondences& given,
                                        const std::optional<KnownLens>& known_camera,
                                        const ViewVariation& variation, const Options& options) {
  const bool camera_known = known_camera.has_value();
  Correspondences ordered = given;
  // Skew and k3 are small: a start does without them, and settles the order of symmetric boards.
  Options of_start = options;
  for (LensOptions* lens : {&of_start.camera, &of_start.projector})
    lens->held.insert(lens->held.end(), {"skew", "k3"});
  Start start = find_start(ordered, known_camera, of_start);
  free_lenses(ordered, options, camera_known, start);
  start.bundle_options.pose_groups = pose_groups(ordered);
  start.variation = variation;
  ShapedSolution shaped = solve_with_shape(ordered, start, options);
  Solution chosen;
  std::vector<LensAlternative> alternatives =
      choose_lenses(shaped.data, start.used, shaped.solution, options, camera_known, chosen);
  const bool another = std::any_of(alternatives.begin(), alternatives.end(), [](const LensAlternative& one) {
    return one.chosen && one.model != kUsualLensModel;
  });
  if (another) {
    const Start before = start;
    begin_again(chosen, start);
    try {
      shaped = solve_with_shape(shaped.data, start, options);
    } catch (const Error& error) {  // good enough to be judged, not to be solved to the end
      start = before;
      reject_chosen(alternatives, error.why());
    }
  }
  return {std::move(start), std::move(shaped), std::move(alternatives)};
}

/// The same, without what the lenses do beyond their models, if the residuals show that.
struct DistortionSolution {
  Start start;
  ShapedSolution shaped;
  std::vector<LensAlternative> alternatives;
  ResidualDistortionEstimate beyond;
};

DistortionSolution solve_with_residual_distortion(const Correspondences& given,
                                                  const std::optional<KnownLens>& known_camera,
                                                  const Options& options) {
  constexpr int kRounds = 4;
  constexpr double kSettled = 0.03;  // of the distortion's RMS
  ChosenSolution chosen = solve_with_chosen_lenses(given, known_camera, {}, options);
  ResidualDistortionEstimate beyond;
  for (int round = 0; round < kRounds; ++round) {
    report(options, "residual distortion", 0.6);
    std::optional<ResidualDistortionEstimate> next =
        estimate_residual_distortion(chosen.shaped.data, chosen.shaped.solution, beyond.of_devices);
    if (!next || (beyond.of_devices.empty() && !next->any())) break;
    const bool settled = !beyond.of_devices.empty() && relative_change(*next, beyond) < kSettled;
    const ResidualDistortionEstimate before = std::exchange(beyond, *std::move(next));
    if (settled) break;
    try {
      chosen = solve_with_chosen_lenses(without_residual_distortion(given, beyond.of_devices), known_camera,
                                        chosen.shaped.solution.options.variation, options);
    } catch (const Error&) {  // the lens's own terms do not settle without it
      beyond = before;
      break;
    }
  }
  return {std::move(chosen.start), std::move(chosen.shaped), std::move(chosen.alternatives),
          std::move(beyond)};
}

void tell_residual_distortion(const Correspondences& data, const ResidualDistortionEstimate& beyond,
                              CalibrationResult& result) {
  for (std::size_t d = 0; d < beyond.of_devices.size(); ++d)
    if (!beyond.of_devices[d].empty())
      result.diagnostics.note(
          "residual_distortion",
          data.devices[d].name + "'s lens departs from its model by " + px(beyond.rms_px[d]) +
              " RMS, smoothly over the picture: that is estimated with the rest, so that it "
              "does not pull the lens's parameters, and included in their sigmas");
}

Correspondences without_views(const Correspondences& given, const std::vector<ForeignView>& foreign) {
  Correspondences data = given;
  for (const ForeignView& one : foreign) {
    View& view = data.views[one.view];
    for (auto& of_device : view.observations) of_device.clear();
    view.light_points.clear();
  }
  return data;
}

/// The same, without views whose camera images are of another capture as well; `foreign` receives these. The camera's corners
/// of a view stay where they agree with the camera of the others: then the projector alone is at fault.
DistortionSolution solve_own_views(const Correspondences& given, const std::optional<KnownLens>& known_camera,
                                   const Options& options, std::vector<ForeignView>& foreign) {
  DistortionSolution all = solve_with_residual_distortion(given, known_camera, options);
  if (options.outlier_sigmas <= 0) return all;
  foreign = views_of_another_capture(all.shaped.data, all.start.used, all.shaped.solution);
  if (foreign.empty()) return all;
  try {
    DistortionSolution others =
        solve_with_residual_distortion(without_views(given, foreign), known_camera, options);
    const std::size_t suspected = foreign.size();
    const auto is_sound = [&](const ForeignView& one) {
      return agrees_with_camera(all.shaped.data, all.start.used, all.shaped.solution, others.shaped.data,
                                others.shaped.solution, one.view);
    };
    foreign.erase(std::remove_if(foreign.begin(), foreign.end(), is_sound), foreign.end());
    if (foreign.empty()) return all;
    return foreign.size() == suspected
               ? std::move(others)
               : solve_with_residual_distortion(without_views(given, foreign), known_camera, options);
  } catch (const Error&) {  // too few without them
    foreign.clear();
    return all;
  }
}

void tell_foreign_views(const std::vector<ForeignView>& foreign, CalibrationResult& result) {
  for (const ForeignView& one : foreign) {
    ViewResult& view = result.views[one.view];
    view.note = "rejected: " + one.cause;
    result.diagnostics.warn("view_left_out", "view " + view.name + " rejected: " + one.cause);
  }
}

/// A known camera against the one that the same views determine without it; nothing where they do not.
void check_known_camera(const Correspondences& given, const KnownLens& known, const Options& options,
                        CalibrationResult& result) {
  report(options, "check of the known camera", 0.95);
  try {
    const DistortionSolution own = solve_with_residual_distortion(given, std::nullopt, options);
    const Solution& solution = own.shaped.solution;
    Points2 pixels;
    for (std::size_t v = 0; v < own.shaped.data.views.size(); ++v)
      for (std::size_t i = 0; i < own.shaped.data.views[v].observations[0].size(); ++i)
        if (solution.used[v][0][i]) pixels.push_back(own.shaped.data.views[v].observations[0][i].pixel);
    const std::string& device = given.devices.front().name;
    const Gate gate =
        known_lens_gate(lens_difference(pixels, known, solution.state().lenses[0],
                                        sigmas_of(own.shaped, own.beyond).robust.devices, device),
                        device, spread_of(own.shaped.data, solution.state(), solution.used, 0).rms_px);
    result.rig.quality.gates.push_back(gate);
    if (!gate.passed) result.diagnostics.fail("gate_failed", gate.name + ": " + gate.detail);
  } catch (const Error&) {  // that is why the camera is given
  }
}

CalibrationResult run(const Correspondences& given, const std::optional<KnownLens>& known_camera,
                      const Options& options) {
  require_consistent(given);
  std::vector<ForeignView> foreign;
  auto [start, shaped, alternatives, beyond] = solve_own_views(given, known_camera, options, foreign);
  report(options, "covariance", 0.75);
  Sigmas sigmas = sigmas_of(shaped, beyond);
  const std::vector<WeaklyObservable> open =
      regularise_weak_parameters(shaped, sigmas, start, beyond, known_camera.has_value(), options);
  average_terms(shaped.data, options, beyond.any(), shaped.solution, sigmas.robust.devices);
  const Correspondences& data = shaped.data;
  const Solution& solution = shaped.solution;
  const std::vector<RigMotion> motions = rig_motions(data, solution);
  add_motions(motions, sigmas.robust.devices);
  CalibrationResult result = describe(data, start, solution, sigmas.formal, motions);
  result.solved = {data, solution.used, solution.state(), solution.options};
  result.rig.covariance = rig_covariance(sigmas.robust.devices, data, solution.state());
  result.variance_ratio = sigmas.robust.variance_ratio;
  result.sigmas_from_views = sigmas.robust.inflated;
  if (result.sigmas_from_views)
    result.diagnostics.note(
        "sigmas_from_views",
        "views disagree " + times(std::sqrt(result.variance_ratio)) +
            " more than detection noise predicts; uncertainties are from a leave-one-view-out jackknife");
  tell_foreign_views(foreign, result);
  tell_lenses(std::move(alternatives), result);
  tell_residual_distortion(data, beyond, result);
  for (const std::string& sentence : in_words(open, data))
    result.diagnostics.warn("weakly_observable", sentence);
  tell_shape(shaped, result);
  const std::string repeated = repeated_poses(data, solution.used, solution.options.pose_groups);
  if (!repeated.empty()) result.diagnostics.warn("repeated_poses", repeated);
  const std::string in_part = in_first_part(data, solution.used);
  if (!in_part.empty()) result.diagnostics.warn("points_in_first_part", in_part);
  result.size_to_measure = printed_size_to_measure(data.board);
  if (options.holdout)
    hold_out_views(data, start, solution, beyond, sigmas.robust.inflated ? sigmas.robust.variance_ratio : 1,
                   options, result);
  check_result(data, start, solution, shaped.shape, result);
  if (known_camera) check_known_camera(without_views(given, foreign), *known_camera, options, result);
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
