#include "shape_choice.hpp"

#include <algorithm>
#include <optional>

#include "flex.hpp"
#include "pose_groups.hpp"
#include "shape.hpp"

namespace procam::calibrate {
namespace {

/// How much better views must be predicted before more numbers are worth their freedom. The test below is the sharper of
/// the two: a crumpled sheet that no model predicts well passes this one narrowly.
constexpr double kShapeGain = 0.97;
/// And by how many standard errors the shape must explain more than noise: with few views, most of them may
/// be predicted better by chance. Flat boards in numbers came to 3 at most, bent ones to 17 at least.
constexpr double kShapeSigmas = 5;
constexpr int kViewsForShape = 4;
/// What the likelihood must gain before views have a flex of their own: less comes by chance once in 10^4 sessions.
constexpr double kFlexGain = 16;

/// How a board may differ from the printed one.
struct ShapeModel {
  double sigma;  ///< metres by which points may lie off their places on the sheet
  double freedom;
  bool settles_order;  ///< a bent sheet looks the same when it is turned by 180 degrees
};
/// Like a sheet: three curvatures.
ShapeModel bent_sheet(const Points3& printed) {
  return {sheet_sigma(printed), 3, false};
}
/// Each point has its own place.
ShapeModel free_points(const Points3& printed) {
  return {board_sigma(printed), 3 * double(printed.size()) - 7, true};
}

/// nullopt when it does not converge. With `flex_sigma` > 0, the sheet bends anew in each view.
std::optional<ShapedSolution> solve_shape(const ShapedSolution& flat, const ShapeModel& model,
                                          double flex_sigma, const Start& start, const Options& options) {
  ShapedSolution shaped{flat.data, {}, {}, {}, model.freedom};
  BundleState state = flat.solution.state();
  if (model.settles_order)
    shaped.turned = settle_order_by_shape(shaped.data, flat.solution.used, state, flat.solution.options);
  BundleOptions with_shape = flat.solution.options;
  with_shape.board_sigma = model.sigma;
  with_shape.flex_sigma = flex_sigma;
  if (flex_sigma > 0 && state.flex.empty()) state.flex.assign(state.rig_from_board.size(), Vec3::Zero());
  try {
    // From all points again: those that the flat board rejected are the ones that show the shape.
    shaped.solution = solve(shaped.data, state, with_shape, start.first, start.used, options);
  } catch (const Error&) {
    if (options.board_shape == BoardShape::kFree) throw;
    return std::nullopt;
  }
  shaped.shape = measure_shape(shaped.data, shaped.solution);
  shaped.shape.free_points = model.settles_order;
  return shaped;
}

/// Does the solution's linearisation show that the sheet bends anew in each view?
bool may_flex(const ShapedSolution& shaped, const Points3& printed) {
  Solution with_flex = shaped.solution;
  with_flex.options.board_sigma = std::max(with_flex.options.board_sigma, sheet_sigma(printed));
  with_flex.options.flex_sigma = loose_flex(printed);
  with_flex.bundle.state.flex.assign(with_flex.state().rig_from_board.size(), Vec3::Zero());
  const std::optional<FlexSize> size = most_likely_flex(shaped.data, with_flex);
  return size && size->gain >= kFlexGain;
}

/// The same with a flex in each view, of the size that the views show; nullopt where they show none. Begins with `sigma`.
std::optional<ShapedSolution> solve_flexing(const ShapedSolution& flat, const ShapeModel& model, double sigma,
                                            const Start& start, const Options& options) {
  constexpr int kRounds = 5;
  constexpr double kSettled = 0.1;  // share of the size
  std::optional<ShapedSolution> flexing;
  for (int round = 0; round < kRounds; ++round) {
    flexing = solve_shape(flat, model, sigma, start, options);
    if (!flexing) return std::nullopt;
    const std::optional<FlexSize> size = most_likely_flex(flexing->data, flexing->solution);
    if (!size || size->gain < kFlexGain) return std::nullopt;
    if (std::abs(size->sigma - sigma) < kSettled * sigma) break;
    sigma = size->sigma;
  }
  flexing->shape.flex_rms = flex_rms(flexing->data, flexing->solution);
  // What is open of the common sheet is small beside what each view adds to it: held, it spares all that follows three
  // unknowns a point.
  if (!model.settles_order) flexing->solution.options.board_sigma = 0;
  return flexing;
}

void report_shape(const Options& options) {
  if (options.progress) options.progress("the board's shape", 0.5);
}

/// Is the model with more freedom worth it? Writes the held-out errors of both to `general.shape`.
bool is_better(const ShapedSolution& simple, ShapedSolution& general) {
  const Solution &a = simple.solution, &b = general.solution;
  UsedMask judged = b.used;
  for (std::size_t v = 0; v < judged.size(); ++v)
    for (std::size_t d = 0; d < judged[v].size(); ++d)
      for (std::size_t i = 0; i < judged[v][d].size(); ++i)
        judged[v][d][i] = judged[v][d][i] || a.used[v][d][i];
  const auto error = predicted_holdout(simple.data, a.used, judged, a.state(), a.options);
  const auto shaped_error = predicted_holdout(general.data, b.used, judged, b.state(), b.options);
  general.shape.holdout_free_px = shaped_error.value_or(0);
  general.shape.holdout_flat_px = simple.shape.free ? simple.shape.holdout_flat_px : error.value_or(0);
  return error && shaped_error && *shaped_error < kShapeGain * *error &&
         explained_by_shape(simple.data, a, general.data, b, general.freedom - simple.freedom,
                            general.freedom) > kShapeSigmas;
}

/// Do the detectors' own covariances leave something of the residuals for a shape to explain?
bool is_unexplained(const Solution& solution) {
  return std::any_of(solution.options.noise.begin(), solution.options.noise.end(),
                     [](const ResidualNoise& noise) { return noise.floor_px > 0; });
}

}  // namespace

ShapedSolution solve_with_shape(const Correspondences& data, const Start& start, const Options& options) {
  const ShapedSolution flat{
      data, solve(data, start.state, start.bundle_options, start.first, start.used, options), {}, {}};
  if (options.board_shape == BoardShape::kFlat) return flat;
  const bool automatic = options.board_shape == BoardShape::kAuto;
  if (automatic && count_groups(start.used, start.bundle_options.pose_groups) < kViewsForShape) return flat;

  const Points3 printed = points_in_board(data.board);
  ShapedSolution best = flat;
  double flex_sigma = start.flex_sigma > 0 ? start.flex_sigma : loose_flex(printed);
  bool flexes = false;
  if (automatic) {
    if (is_unexplained(flat.solution)) {
      report_shape(options);
      std::optional<ShapedSolution> sheet = solve_shape(flat, bent_sheet(printed), 0, start, options);
      if (sheet && is_better(flat, *sheet)) best = std::move(*sheet);
    }
    if (may_flex(best, printed)) {
      report_shape(options);
      std::optional<ShapedSolution> flexing =
          solve_flexing(flat, bent_sheet(printed), flex_sigma, start, options);
      flexes = flexing.has_value();
      if (flexes) {
        is_better(flat, *flexing);  // for the held-out errors, which are reported
        best = std::move(*flexing);
        flex_sigma = best.solution.options.flex_sigma;
      }
    }
    if (!is_unexplained(best.solution)) return best;
  }
  report_shape(options);
  std::optional<ShapedSolution> free;
  if (flexes) free = solve_flexing(flat, free_points(printed), flex_sigma, start, options);
  if (!free) free = solve_shape(flat, free_points(printed), 0, start, options);
  if (!free) return best;
  const bool better = is_better(best, *free);
  if (better || !automatic) return std::move(*free);
  if (!best.shape.free) {
    best.shape.holdout_flat_px = free->shape.holdout_flat_px;
    best.shape.holdout_free_px = free->shape.holdout_free_px;
  }
  return best;
}

}  // namespace procam::calibrate
