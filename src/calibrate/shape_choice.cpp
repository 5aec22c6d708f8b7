#include "shape_choice.hpp"

#include <algorithm>
#include <optional>

#include "pose_groups.hpp"
#include "rig_motion.hpp"
#include "shape.hpp"
#include "view_variation.hpp"

namespace procam::calibrate {
namespace {

/// How much better views must be predicted before more numbers are worth their freedom. The test below is the sharper of
/// the two: a crumpled sheet that no model predicts well passes this one narrowly.
constexpr double kShapeGain = 0.97;
/// And by how many standard errors the shape must explain more than noise: with few views, most of them may
/// be predicted better by chance. Flat boards in numbers came to 3 at most, bent ones to 17 at least.
constexpr double kShapeSigmas = 5;
constexpr int kViewsForShape = 4;

/// How a board may differ from the printed one.
struct ShapeModel {
  double sigma;  ///< metres by which points may lie off their places on the sheet
  double freedom;
  bool settles_order;  ///< a bent sheet looks the same when it is turned by 180 degrees
};
/// As printed, and flat.
constexpr ShapeModel kFlatBoard{0, 0, false};
/// Like a sheet: three curvatures.
ShapeModel bent_sheet(const Points3& printed) {
  return {sheet_sigma(printed), 3, false};
}
/// Each point has its own place.
ShapeModel free_points(const Points3& printed) {
  return {board_sigma(printed), 3 * double(printed.size()) - 7, true};
}

/// nullopt when it does not converge.
std::optional<ShapedSolution> solve_shape(const ShapedSolution& flat, const ShapeModel& model,
                                          const ViewVariation& variation, const Start& start,
                                          const Options& options) {
  ShapedSolution shaped{flat.data, {}, {}, {}, model.freedom};
  BundleState state = flat.solution.state();
  if (model.settles_order)
    shaped.turned = settle_order_by_shape(shaped.data, flat.solution.used, state, flat.solution.options);
  BundleOptions with_shape = flat.solution.options;
  with_shape.board_sigma = model.sigma;
  free_variation(variation, state, with_shape);
  try {
    // From all points again: those that the flat board rejected are the ones that show the shape. Where a view's image is
    // elsewhere, its points agree with the rig only once its change is estimated.
    const UsedMask& first = variation.of_image() ? start.used : start.first;
    shaped.solution = solve(shaped.data, state, with_shape, first, start.used, options);
  } catch (const Error&) {
    if (options.board_shape == BoardShape::kFree) throw;
    return std::nullopt;
  }
  if (model.sigma > 0) shaped.shape = measure_shape(shaped.data, shaped.solution);
  shaped.shape.free_points = model.settles_order;
  return shaped;
}

/// Too large to begin with: what the views contradict most was rejected before it could be allowed for.
ViewVariation times(double factor, const ViewVariation& sizes) {
  return {factor * sizes.flex, factor * sizes.focus, factor * sizes.shift_px};
}

double change_of(const ViewVariation& a, const ViewVariation& b) {
  double largest = 0;
  for (double ViewVariation::*size : {&ViewVariation::flex, &ViewVariation::focus, &ViewVariation::shift_px})
    if (a.*size != b.*size)
      largest = std::max(largest, std::abs(a.*size - b.*size) / std::max(a.*size, b.*size));
  return largest;
}

/// The same with what differs from view to view, of the size that the views show; nullopt where they show none. Begins with
/// `variation`. A board that flexes has a sheet at least.
std::optional<ShapedSolution> solve_varying(const ShapedSolution& flat, const ShapeModel& simplest,
                                            ViewVariation variation, MayVary may, const Start& start,
                                            const Options& options) {
  constexpr int kRounds = 5;
  constexpr double kSettled = 0.1;  // share of the size
  const ShapeModel sheet = bent_sheet(points_in_board(flat.data.board));
  std::optional<ShapedSolution> varying;
  for (int round = 0; round < kRounds; ++round) {
    const ShapeModel& model = simplest.sigma == 0 && variation.flex > 0 ? sheet : simplest;
    varying = solve_shape(flat, model, variation, start, options);
    if (!varying) return std::nullopt;
    const ViewVariation next = most_likely_variation(varying->data, varying->solution, may);
    if (!next.any()) return std::nullopt;
    if (change_of(next, variation) < kSettled) break;
    variation = next;
  }
  if (variation.flex == 0) return varying;
  varying->shape.flex_rms = flex_rms(varying->data, varying->solution);
  // What is open of the common sheet is small beside what each view adds to it: held, it spares all that follows three
  // unknowns a point.
  if (!simplest.settles_order) varying->solution.options.board_sigma = 0;
  return varying;
}

void report_shape(const Options& options) {
  if (options.progress) options.progress("the board's shape", 0.5);
}

/// RMS on held-out views, to first order, of both on the points that either uses.
struct HeldOut {
  std::optional<double> simple, general;
};
HeldOut held_out(const ShapedSolution& simple, const ShapedSolution& general) {
  const Solution &a = simple.solution, &b = general.solution;
  UsedMask judged = b.used;
  for (std::size_t v = 0; v < judged.size(); ++v)
    for (std::size_t d = 0; d < judged[v].size(); ++d)
      for (std::size_t i = 0; i < judged[v][d].size(); ++i)
        judged[v][d][i] = judged[v][d][i] || a.used[v][d][i];
  return {predicted_holdout(simple.data, a.used, judged, a.state(), a.options),
          predicted_holdout(general.data, b.used, judged, b.state(), b.options)};
}

/// Is the model with more freedom worth it? Writes the held-out errors of both to `general.shape`.
bool is_better(const ShapedSolution& simple, ShapedSolution& general) {
  const Solution &a = simple.solution, &b = general.solution;
  const auto [error, shaped_error] = held_out(simple, general);
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

/// A rig that came to stand elsewhere displaces images as well, for one reason and once. One device alone shows a change as
/// another pose of the board, and nothing contradicts it.
MayVary may_vary(const ShapedSolution& shaped, bool sheet) {
  return {sheet, shaped.data.devices.size() > 1 && rig_motions(shaped.data, shaped.solution).empty()};
}

/// Devices predict each other in held-out views as well with changes as without, as far as these are real: what nobody
/// knows of a held-out view is the same either way. Changes that stand for something else, where the views determine them poorly,
/// make it worse. Simulated and real cameras that did change came to 1.2 times at most, others to 12 times.
constexpr double kWorseHeldOut = 1.5;
bool is_confirmed(const ShapedSolution& fixed, const ShapedSolution& varying) {
  const HeldOut errors = held_out(fixed, varying);
  return errors.simple && errors.general && *errors.general < kWorseHeldOut * *errors.simple;
}

/// On the simplest board that shows what differs from view to view; nullopt where nothing does.
std::optional<ShapedSolution> varying_beside(const ShapedSolution& fixed, const ShapeModel& simplest,
                                             MayVary may, const ShapedSolution& flat, const Start& start,
                                             const Options& options) {
  const ViewVariation found = most_likely_variation(fixed.data, fixed.solution, may);
  if (!found.any()) return std::nullopt;
  report_shape(options);
  const bool begun = start.variation.any() && (may.images || !start.variation.of_image());
  std::optional<ShapedSolution> varying =
      solve_varying(flat, simplest, begun ? start.variation : times(3, found), may, start, options);
  if (!varying) return std::nullopt;
  if (fixed.shape.free && !varying->shape.free) {
    const ViewVariation& variation = varying->solution.options.variation;
    std::optional<ShapedSolution> bent =
        solve_varying(flat, bent_sheet(points_in_board(flat.data.board)), variation, may, start, options);
    if (bent && is_better(*varying, *bent)) varying = std::move(*bent);
  }
  if (!is_confirmed(fixed, *varying)) {
    if (!varying->solution.options.variation.of_image()) return std::nullopt;
    may.images = false;
    return varying_beside(fixed, simplest, may, flat, start, options);
  }
  if (varying->shape.free) is_better(flat, *varying);  // for the held-out errors, which are reported
  return varying;
}

/// `fixed`, or with what differs from view to view where that shows; `sheet`: may it bend?
ShapedSolution with_variation(const ShapedSolution& fixed, const ShapeModel& simplest, bool sheet,
                              const ShapedSolution& flat, const Start& start, const Options& options) {
  std::optional<ShapedSolution> varying =
      varying_beside(fixed, simplest, may_vary(fixed, sheet), flat, start, options);
  if (!varying) return fixed;
  return std::move(*varying);
}

}  // namespace

ShapedSolution solve_with_shape(const Correspondences& data, const Start& start, const Options& options) {
  const ShapedSolution flat{
      data, solve(data, start.state, start.bundle_options, start.first, start.used, options), {}, {}};
  const bool enough = count_groups(start.used, start.bundle_options.pose_groups) >= kViewsForShape;
  const Points3 printed = points_in_board(data.board);
  switch (options.board_shape) {
    case BoardShape::kFlat:
      return enough ? with_variation(flat, kFlatBoard, false, flat, start, options) : flat;
    case BoardShape::kFree: {
      report_shape(options);
      ShapedSolution free = *solve_shape(flat, free_points(printed), {}, start, options);
      if (enough) free = with_variation(free, free_points(printed), false, flat, start, options);
      is_better(flat, free);  // for the held-out errors, which are reported
      return free;
    }
    case BoardShape::kAuto:
      break;
  }
  if (!enough) return flat;

  ShapedSolution best = flat;
  if (is_unexplained(flat.solution)) {
    report_shape(options);
    std::optional<ShapedSolution> sheet = solve_shape(flat, bent_sheet(printed), {}, start, options);
    if (sheet && is_better(flat, *sheet)) best = std::move(*sheet);
  }
  best = with_variation(best, kFlatBoard, true, flat, start, options);
  if (!is_unexplained(best.solution)) return best;
  report_shape(options);
  std::optional<ShapedSolution> free;
  if (const ViewVariation& variation = best.solution.options.variation; variation.any())
    free = solve_varying(flat, free_points(printed), variation, {true, variation.of_image()}, start, options);
  if (!free) free = solve_shape(flat, free_points(printed), {}, start, options);
  if (!free) return best;
  if (is_better(best, *free)) return std::move(*free);
  if (!best.shape.free) {
    best.shape.holdout_flat_px = free->shape.holdout_flat_px;
    best.shape.holdout_free_px = free->shape.holdout_free_px;
  }
  return best;
}

}  // namespace procam::calibrate
