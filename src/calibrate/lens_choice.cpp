#include "lens_choice.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "lens_models.hpp"
#include "prior_terms.hpp"
#include "procam/calibrate/lens_model.hpp"
#include "residual_blocks.hpp"
#include "rig_covariance.hpp"
#include "shape.hpp"
#include "uncertainty.hpp"

namespace procam::calibrate {
namespace {

/// How much better (as an error, not its square) views must be predicted before the usual model is left: it
/// serves nearly every lens, and what predicts the views no worse may still mislead between and beyond them.
constexpr double kLensGain = 0.95;
/// And by how many standard errors of the difference. One is enough only for a gain beyond kLargeLensGain: with
/// eight noisy views, one in six wrong models gains one, but one view at the rim may carry all of a true gain.
constexpr double kLensErrors = 2, kLargeLensGain = 0.7;
/// Beyond this many sigmas an observation is a blunder, and no worse for being further off.
constexpr double kWorst = 5;
constexpr double kRoughTolerance = 1e-8;  ///< of a model's cost: enough to judge by

const LensOptions& lens_options(const Options& options, DeviceKind kind) {
  return kind == DeviceKind::kCamera ? options.camera : options.projector;
}

using HeldOut = std::vector<std::optional<BundleState>>;  ///< by view

struct LensTrial {
  BundleState state;
  BundleOptions options;
  HeldOut held_out;
  LensAlternative told;
};

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? 0 : sum / double(values.size());
}

/// One standard error of the mean of a[i] - b[i].
double error_of_difference(const std::vector<double>& a, const std::vector<double>& b) {
  const double difference = mean(a) - mean(b);
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i] - difference) * (a[i] - b[i] - difference);
  const double n = double(a.size());
  return n > 1 ? std::sqrt(sum / (n * (n - 1))) : 0;
}

/// Mean squared residuals of left-out views, in units of `variance` (by device), blunders capped; those of a
/// pose group together.
std::vector<double> squares_by_view(const Correspondences& data, const UsedMask& all,
                                    const Solution& solution, const std::vector<double>& variance,
                                    const HeldOut& states) {
  struct Sum {
    double squares = 0;
    int count = 0;
  };
  std::map<int, Sum> groups;
  for (std::size_t v = 0; v < states.size(); ++v) {
    if (!states[v]) continue;
    auto& [sum, count] = groups[pose_group(solution.options, v)];
    for (std::size_t d = 0; d < data.devices.size(); ++d) {
      if (solution.rejected[v][d]) continue;
      for (const Measurement& m : measurements_of(data, int(v), int(d))) {
        if (!all[v][d][std::size_t(m.index)]) continue;
        const auto r = reprojection_residual(*states[v], m);
        sum += r ? std::min(r->squaredNorm() / variance[d], kWorst * kWorst) : kWorst * kWorst;
        ++count;
      }
    }
  }
  std::vector<double> squares;
  for (const auto& [group, sum] : groups)
    if (sum.count > 0) squares.push_back(sum.squares / sum.count);
  return squares;
}

/// Groups of views that can be held out.
std::size_t groups_left(const BundleOptions& options, const HeldOut& states) {
  std::set<int> groups;
  for (std::size_t v = 0; v < states.size(); ++v)
    if (states[v]) groups.insert(pose_group(options, v));
  return groups.size();
}

/// RMS of a device on left-out views, over what the solution uses, pixels; NaN where none has any.
double held_out_rms(const Correspondences& data, const Solution& solution, std::size_t device,
                    const HeldOut& states) {
  double sum = 0;
  int count = 0;
  for (std::size_t v = 0; v < states.size(); ++v) {
    if (!states[v]) continue;
    const Spread spread = spread_of(data, *states[v], solution.used, int(device), int(v));
    sum += spread.rms_px * spread.rms_px * spread.count;
    count += spread.count;
  }
  return count > 0 ? std::sqrt(sum / count) : std::nan("");
}

/// The solution with one device's lens in another model.
LensTrial try_lens(const Correspondences& data, const Solution& solution, std::size_t device,
                   const LensModel& model, const std::vector<LensPrior>& by_user) {
  LensTrial trial{solution.state(), solution.options, {}, {}};
  trial.told.device = int(device);
  trial.told.model = model.name;
  trial.told.terms = model.terms();
  trial.state.lenses[device] = in_model(trial.state.lenses[device], model);
  trial.options.held[device] = held_in(model, solution.options.held[device]);
  trial.options.tolerance = kRoughTolerance;
  trial.options.priors.resize(data.devices.size());
  trial.options.priors[device] = by_user;
  for (LensPrior& prior : known_of_any_lens(trial.state.lenses[device]))
    trial.options.priors[device].push_back(std::move(prior));
  try {
    const BundleResult bundle = bundle_adjust(data, solution.used, trial.state, trial.options);
    trial.state = bundle.state;
    trial.held_out = views_held_out(data, solution.used, solution.used, trial.state, trial.options);
    trial.told.holdout_px = held_out_rms(data, solution, device, trial.held_out);
    const Camera& lens = trial.state.lenses[device];
    const bool camera = data.devices[device].kind == DeviceKind::kCamera;
    const double folded =
        camera ? folded_share(lens, reach_of(data, solution.used, device, lens)) : folded_share(lens);
    if (folded > 0) trial.told.ruled_out = "folds back within the picture";
    trial.told.rig = rig_of(data, trial.state);
    trial.told.rig.covariance = rig_covariance(
        bundle_covariance(data, solution.used, trial.state, trial.options).devices, data, trial.state);
    if (!bundle.converged) trial.told.ruled_out = "did not converge";
    // NaN, or an error larger than the image, which is none.
    if (!(trial.told.holdout_px <= data.devices[device].size.width)) {
      trial.held_out.clear();
      trial.told.holdout_px = std::nan("");
      if (trial.told.ruled_out.empty()) trial.told.ruled_out = "not determined without every view";
    }
  } catch (const Error&) {
    trial.held_out.clear();
    trial.told.rig = Rig();
    trial.told.holdout_px = std::nan("");
    trial.told.ruled_out = "not determined by these views";
  }
  trial.options.tolerance = solution.options.tolerance;
  return trial;
}

const Camera& lens_of(const LensTrial& trial) {
  return trial.state.lenses[std::size_t(trial.told.device)];
}

/// The usual model, unless others predict the views better by kLensGain and by more than kLensErrors standard errors
/// of the difference; then the one with the fewest terms within a standard error of the best (L. Breiman et al.,
/// "Classification and Regression Trees", 1984, section 3.4.3). Never one with fewer terms than the usual:
/// held-out views show its deficit weakly, its sigmas not at all, and the light shows it beyond the views
/// (measured: docs/calibration.md). Terms that the views do not determine are kept near zero by what is known
/// of any lens instead.
std::size_t choose(const std::vector<LensTrial>& trials, std::size_t usual) {
  const auto& of_usual = trials[usual].told.by_view;
  const auto possible = [&](std::size_t i) {
    return trials[i].told.ruled_out.empty() &&
           (trials[i].told.terms >= trials[usual].told.terms ||
            std::holds_alternative<FisheyeDistortion>(lens_of(trials[i]).distortion));
  };
  std::size_t best = usual;
  for (std::size_t i = 0; i < trials.size(); ++i)
    if (possible(i) && mean(trials[i].told.by_view) < mean(trials[best].told.by_view)) best = i;
  const auto& of_best = trials[best].told.by_view;
  const double gain = std::sqrt(mean(of_best) / mean(of_usual));
  const double errors = gain < kLargeLensGain ? 1 : kLensErrors;
  const bool worth_it =
      gain < kLensGain && mean(of_best) + errors * error_of_difference(of_best, of_usual) < mean(of_usual);
  if (!worth_it) return usual;
  for (std::size_t i = 0; i < trials.size(); ++i)  // from the fewest terms on
    if (possible(i) &&
        mean(trials[i].told.by_view) <= mean(of_best) + error_of_difference(of_best, trials[i].told.by_view))
      return i;
  return best;
}

}  // namespace

std::vector<std::string> held_in(const LensModel& model, const std::vector<std::string>& by_user) {
  std::vector<std::string> held = model.held;
  for (const std::string& name : by_user)
    if (std::count(kIntrinsicsNames.begin(), kIntrinsicsNames.end(), name) > 0) held.push_back(name);
  return held;
}

std::vector<LensAlternative> choose_lenses(const Correspondences& data, const UsedMask& all,
                                           const Solution& solution, const Options& options,
                                           bool camera_known, Solution& next) {
  next = solution;
  std::vector<LensAlternative> told;
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    const DeviceKind kind = data.devices[d].kind;
    if (!lens_options(options, kind).choose || (d == 0 && camera_known)) continue;
    std::vector<LensTrial> trials;
    std::size_t usual = 0;
    for (const LensModel& model : candidate_lens_models(next.state().lenses[d], kind)) {
      if (model.name == kUsualLensModel) usual = trials.size();
      trials.push_back(try_lens(data, next, d, model, lens_options(options, kind).priors));
    }
    // Too few views to leave one out, or none of this device among those that can be.
    if (groups_left(next.options, trials[usual].held_out) < 2) continue;
    std::vector<double> variance;
    for (std::size_t i = 0; i < data.devices.size(); ++i) {
      const double rms = held_out_rms(data, next, i, trials[usual].held_out);
      variance.push_back(rms > 1e-6 ? rms * rms : 1e-12);
    }
    for (LensTrial& trial : trials) {
      trial.told.by_view = squares_by_view(data, all, next, variance, trial.held_out);
      if (trial.told.ruled_out.empty() &&
          trial.told.by_view.size() != groups_left(next.options, trials[usual].held_out))
        trial.told.ruled_out = "not determined without every view";
    }
    const std::size_t chosen = choose(trials, usual);
    trials[chosen].told.chosen = true;
    for (const LensTrial& trial : trials) told.push_back(trial.told);
    if (chosen == usual) continue;
    next.bundle.state = trials[chosen].state;
    next.options = trials[chosen].options;
  }
  return told;
}

}  // namespace procam::calibrate
