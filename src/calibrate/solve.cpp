#include "solve.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "joined.hpp"
#include "procam/core/base/stats.hpp"
#include "residual_blocks.hpp"

namespace procam::calibrate {
namespace {

/// The share of residuals that the noise model must account for. A bent board pushes a tenth of its corners
/// far out, again and again in the same place: that is what the board does, not a blunder, so the noise must
/// not be read from the good half alone. Blunders may still be a tenth.
constexpr double kNoiseQuantile = 0.9;
const double kQuantileOfChi2 = -2 * std::log(1 - kNoiseQuantile);  ///< of |r|^2, two unit normal coordinates

/// Squared length of a residual in the metric of its covariance.
double squared_sigmas(const Vec2& residual, const Mat2& covariance) {
  return residual.dot(covariance.inverse() * residual);
}

/// The noise model under which the 90 % quantile of the residuals is as long as it should be: a scale below
/// one when the detector is too modest, a floor when it promises more than the model keeps.
ResidualNoise estimate_noise(const std::vector<std::pair<Vec2, Mat2>>& residuals) {
  const auto quantile_under = [&](const ResidualNoise& noise) {
    std::vector<double> squares;
    squares.reserve(residuals.size());
    for (const auto& [residual, covariance] : residuals)
      squares.push_back(squared_sigmas(residual, noise.covariance(covariance)));
    return procam::quantile(std::move(squares), kNoiseQuantile);
  };
  ResidualNoise noise;
  if (residuals.size() < 8) return noise;  // too few to say anything
  const double as_promised = quantile_under(noise);
  if (as_promised <= kQuantileOfChi2) {
    // Perfect data would send the scale to zero and the problem's conditioning with it.
    noise.scale = std::max(std::sqrt(as_promised / kQuantileOfChi2), 1e-6);
    return noise;
  }
  double low = 0, high = 1e-3;
  while (quantile_under({1, high}) > kQuantileOfChi2 && high < 1e4) high *= 2;
  for (int i = 0; i < 40; ++i) {
    noise.floor_px = 0.5 * (low + high);
    (quantile_under(noise) > kQuantileOfChi2 ? low : high) = noise.floor_px;
  }
  return noise;
}

constexpr double kRoughly = 1e-6;

/// A view whose residuals are this many times longer than the median view's does not count for the noise -
/// unless they are short all the same: views differ in blur and light, and nothing that slipped slips by
/// less.
constexpr double kGross = 3, kMinSlipPx = 0.5;
/// A view with fewer than this share of its points within the outlier limit disagrees as a whole.
constexpr double kAgreeingShare = 0.5;
constexpr int kViewsThatMustAgree = 3;

/// One device's residuals, view by view, with the place of each verdict in the mask.
struct ViewResiduals {
  std::vector<std::pair<Vec2, Mat2>> residuals;
  std::vector<char*> verdicts;
  std::size_t taken = 0;  ///< of the mask, with or without a residual

  /// The noise quantile of |r|^2, in the detector's own sigmas and in pixels.
  double quantile() const {
    return noise_quantile(
        [](const Vec2& r, const Mat2& covariance) { return squared_sigmas(r, covariance); });
  }
  double quantile_px2() const {
    return noise_quantile([](const Vec2& r, const Mat2&) { return r.squaredNorm(); });
  }

 private:
  template <typename Square>
  double noise_quantile(Square square) const {
    std::vector<double> squares;
    for (const auto& [residual, covariance] : residuals) squares.push_back(square(residual, covariance));
    return procam::quantile(std::move(squares), kNoiseQuantile);
  }
};

/// Residuals of all views but those that are grossly longer than the median view's.
std::vector<std::pair<Vec2, Mat2>> typical_residuals(const std::vector<ViewResiduals>& views) {
  std::vector<double> quantiles;
  for (const ViewResiduals& view : views)
    if (!view.residuals.empty()) quantiles.push_back(view.quantile());
  if (quantiles.empty()) return {};
  const double limit = kGross * kGross * lower_median(std::move(quantiles));
  std::vector<std::pair<Vec2, Mat2>> all;
  for (const ViewResiduals& view : views)
    if (!view.residuals.empty() &&
        (view.quantile() <= limit || view.quantile_px2() <= kMinSlipPx * kMinSlipPx))
      all.insert(all.end(), view.residuals.begin(), view.residuals.end());
  return all;
}

/// One round's judgement: noise by device, verdicts in `used`.
std::vector<ResidualNoise> judge(const Correspondences& data, const BundleState& state, double outlier_sigmas,
                                 UsedMask& used, std::vector<std::vector<char>>& disagrees) {
  std::vector<ResidualNoise> noise;
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    std::vector<ViewResiduals> views(data.views.size());
    for (std::size_t v = 0; v < data.views.size(); ++v)
      for (const Measurement& m : measurements_of(data, int(v), int(d))) {
        char& verdict = used[v][d][std::size_t(m.index)];
        if (!verdict) continue;
        ++views[v].taken;
        const auto judged = judged_residual(state, m);
        verdict = judged.has_value();
        if (!verdict) continue;
        views[v].residuals.emplace_back(judged->residual, judged->covariance);
        views[v].verdicts.push_back(&verdict);
      }
    noise.push_back(estimate_noise(typical_residuals(views)));
    if (outlier_sigmas <= 0) continue;
    for (std::size_t v = 0; v < views.size(); ++v) {
      std::size_t kept = 0;
      for (std::size_t i = 0; i < views[v].residuals.size(); ++i) {
        const auto& [residual, covariance] = views[v].residuals[i];
        *views[v].verdicts[i] =
            squared_sigmas(residual, noise.back().covariance(covariance)) <= outlier_sigmas * outlier_sigmas;
        kept += std::size_t(*views[v].verdicts[i]);
      }
      disagrees[v][d] = views[v].taken > 0 && double(kept) < kAgreeingShare * double(views[v].taken);
    }
  }
  return noise;
}

bool same_noise(const std::vector<ResidualNoise>& a, const std::vector<ResidualNoise>& b) {
  for (std::size_t d = 0; d < a.size(); ++d)
    if (std::abs(a[d].scale - b[d].scale) >= 0.01 * b[d].scale ||
        std::abs(a[d].floor_px - b[d].floor_px) > 0.01 * b[d].floor_px + 1e-6)
      return false;
  return true;
}

/// A camera takes along what it read of projectors; what other devices say of the view still serves.
void leave_out(const Correspondences& data, UsedMask& mask, std::size_t view, std::size_t device) {
  for (std::size_t d = 0; d < mask[view].size(); ++d)
    for (const Measurement& m : measurements_of(data, int(view), int(d)))
      if (d == device || (data.devices[d].kind == DeviceKind::kProjector && m.camera() == int(device)))
        mask[view][d][std::size_t(m.index)] = 0;
}

/// Two cameras that contradict each other in a view, and nothing beside the one that is left: nobody knows
/// which of them is right.
std::optional<std::size_t> unsupported_camera(const Correspondences& data, const UsedMask& mask,
                                              const std::vector<std::vector<char>>& rejected,
                                              std::size_t view) {
  bool disputed = false;
  std::vector<std::size_t> left;
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    disputed |= rejected[view][d] && data.devices[d].kind == DeviceKind::kCamera;
    if (count_used(mask, view, d) > 0) left.push_back(d);
  }
  if (!disputed || left.size() != 1) return std::nullopt;
  return left.front();
}

/// Residuals that a device's noise explains.
struct InlierTest {
  const ResidualNoise& noise;
  double outlier_sigmas;

  bool operator()(const Vec2& residual, const Mat2& covariance) const {
    return squared_sigmas(residual, noise.covariance(covariance)) <= outlier_sigmas * outlier_sigmas;
  }
};

/// Do the device's points of a view agree with a board pose of their own, with the lens as it is?
bool agrees_alone(const Correspondences& data, const UsedMask& mask, const Solution& solution,
                  const InlierTest& is_inlier, std::size_t view, std::size_t device) {
  UsedMask only = only_view(mask, view, int(device));
  const UsedMask asked = only;
  for (const Measurement& m : measurements_of(data, int(view), int(device))) {
    char& used = only[view][device][std::size_t(m.index)];
    used = used && judged_residual(solution.state(), m).has_value();
  }
  const BundleState state =
      bundle_adjust(data, only, solution.state(), hold_devices(solution.options, solution.state())).state;
  int taken = 0, kept = 0;
  for (const Measurement& m : measurements_of(data, int(view), int(device))) {
    if (!asked[view][device][std::size_t(m.index)]) continue;
    ++taken;
    const auto judged = judged_residual(state, m);
    kept += judged && is_inlier(judged->residual, judged->covariance);
  }
  return double(kept) >= kAgreeingShare * double(taken);
}

/// Where a view's one camera and a projector contradict each other, the pose of the board lies between them
/// or with either, by chance. What the projector says was read by the camera and goes with it, so a camera
/// that agrees with the board by itself is believed.
void believe_camera(const Correspondences& data, const UsedMask& mask, double outlier_sigmas,
                    const std::vector<ResidualNoise>& noise, std::vector<std::vector<char>>& disagrees,
                    Solution& solution) {
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    const int camera = posing_camera(data, mask, v);
    if (camera < 0 || !disagrees[v][std::size_t(camera)] || posing_camera(data, mask, v, camera) >= 0)
      continue;
    const auto d = std::size_t(camera);
    if (!agrees_alone(data, mask, solution, {noise[d], outlier_sigmas}, v, d)) continue;
    for (std::size_t p = 0; p < data.devices.size(); ++p)
      disagrees[v][p] = p != d && count_used(mask, v, p) > 0;
    solution.used[v][d] = mask[v][d];
  }
}

void require_agreement(const Correspondences& data, const UsedMask& mask) {
  for (std::size_t d = 0; d < data.devices.size(); ++d) {
    int views = 0;
    for (std::size_t v = 0; v < mask.size(); ++v) views += count_used(mask, v, d) > 0;
    if (views < kViewsThatMustAgree)
      throw Error(
          ErrorKind::kDegenerate, data.devices[d].name,
          "its views contradict each other: no three of them agree on one rig",
          "keep camera and projector fixed to each other, zoom and focus untouched, and the board still "
          "while a view is captured; check that board and order of frames are those stated");
  }
  require_joined(data, mask);
}

}  // namespace

bool takes_part(const UsedMask& used, std::size_t view) {
  for (std::size_t d = 0; d < used[view].size(); ++d)
    if (count_used(used, view, d) > 0) return true;
  return false;
}

int posing_camera(const Correspondences& data, const UsedMask& used, std::size_t view, int other_than) {
  for (std::size_t d = 0; d < data.devices.size(); ++d)
    if (data.devices[d].kind == DeviceKind::kCamera && int(d) != other_than && count_used(used, view, d) > 0)
      return int(d);
  return -1;
}

UsedMask only_view(const UsedMask& used, std::size_t view, int device) {
  UsedMask only = used;
  for (std::size_t v = 0; v < only.size(); ++v)
    for (std::size_t d = 0; d < only[v].size(); ++d)
      if (v != view || (device >= 0 && int(d) != device))
        std::fill(only[v][d].begin(), only[v][d].end(), char(0));
  return only;
}

BundleOptions hold_devices(BundleOptions options, const BundleState& state) {
  for (std::size_t d = 0; d < state.lenses.size(); ++d) {
    options.held[d] = parameter_names(state.lenses[d]);
    options.hold_pose[d] = true;
  }
  options.board_sigma = 0;
  return options;
}

Spread spread_of(const Correspondences& data, const BundleState& state, const UsedMask& used, int device,
                 int view) {
  Spread spread;
  for (std::size_t v = 0; v < data.views.size(); ++v)
    for (std::size_t d = 0; d < data.devices.size(); ++d) {
      if ((view >= 0 && int(v) != view) || (device >= 0 && int(d) != device)) continue;
      for (const Measurement& m : measurements_of(data, int(v), int(d))) {
        if (!used[v][d][std::size_t(m.index)]) continue;
        const auto r = reprojection_residual(state, m);
        if (!r) continue;
        spread.rms_px += r->squaredNorm();
        ++spread.count;
      }
    }
  if (spread.count > 0) spread.rms_px = std::sqrt(spread.rms_px / spread.count);
  return spread;
}

Solution solve(const Correspondences& data, const BundleState& start, const BundleOptions& bundle_options,
               const UsedMask& first, const UsedMask& all, const Options& options) {
  Solution solution;
  solution.used = first;
  solution.bundle.state = start;
  solution.options = bundle_options;
  solution.options.max_iterations = options.max_iterations;
  solution.rejected.assign(data.views.size(), std::vector<char>(data.devices.size(), char(0)));
  UsedMask mask = all;
  // Noise and outliers follow from the residuals and the residuals from them: a handful of rounds settles
  // both. While what is used still changes, a solve need not be exact: converged to the end, a view that
  // disagrees in one device drags its pose until it disagrees in the other as well.
  constexpr int kRounds = 9;
  bool to_the_end = false;
  for (int round = 0; round < kRounds; ++round) {
    if (options.progress) options.progress("bundle adjustment", 0.2 + 0.03 * round);
    const bool last = round + 1 == kRounds;
    solution.options.tolerance = to_the_end || last ? bundle_options.tolerance : kRoughly;
    solution.bundle = bundle_adjust(data, solution.used, solution.state(), solution.options);
    if (last) break;

    UsedMask used = mask;
    std::vector<std::vector<char>> disagrees = solution.rejected;
    for (auto& view : disagrees) std::fill(view.begin(), view.end(), char(0));
    const std::vector<ResidualNoise> noise =
        judge(data, solution.state(), options.outlier_sigmas, used, disagrees);
    const bool all_agree = std::all_of(disagrees.begin(), disagrees.end(), [](const auto& view) {
      return std::count(view.begin(), view.end(), char(1)) == 0;
    });
    const bool same = all_agree && used == solution.used;
    if (to_the_end && same && same_noise(noise, solution.options.noise)) break;
    to_the_end = same;
    solution.used = used;
    solution.options.noise = noise;
    // A view is rejected only after its own noise was estimated, which takes a round.
    if (round == 0) continue;
    believe_camera(data, mask, options.outlier_sigmas, noise, disagrees, solution);
    for (std::size_t v = 0; v < data.views.size(); ++v)
      for (std::size_t d = 0; d < data.devices.size(); ++d) {
        if (!disagrees[v][d]) continue;
        solution.rejected[v][d] = 1;
        leave_out(data, mask, v, d);
        leave_out(data, solution.used, v, d);
      }
    for (std::size_t v = 0; v < data.views.size(); ++v)
      if (const auto alone = unsupported_camera(data, mask, solution.rejected, v)) {
        solution.rejected[v][*alone] = 1;
        leave_out(data, mask, v, *alone);
        leave_out(data, solution.used, v, *alone);
      }
    require_agreement(data, mask);
  }
  if (!solution.bundle.converged)
    throw Error(
        ErrorKind::kNotConverged, "bundle adjustment", solution.bundle.report,
        "tilt the board 20 to 40 degrees about both axes if all views have it parallel; else look for a "
        "view of another board or swapped frames");
  return solution;
}

}  // namespace procam::calibrate
