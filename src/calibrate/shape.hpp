#pragma once
/// Private to calibrate: the board's own shape.
#include <vector>

#include "procam/calibrate/bundle.hpp"
#include "procam/calibrate/result.hpp"
#include "solve.hpp"

namespace procam::calibrate {

/// One sigma by which a point of a printed and mounted sheet lies off its place: 1 % of the distance between
/// neighbouring points (J. Strobl and G. Hirzinger, ICCV workshops 2011, let printed boards go free
/// likewise).
double board_sigma(const Points3& printed);

/// The same of points that lie where the bent sheet has them: no freedom of their own.
double sheet_sigma(const Points3& printed);

/// Where a board looks the same turned by 180 degrees, its shape does not: turns the order of the views (in
/// `data`, all devices, and the poses in `state`) that fit the shape better so. Returns the views that were
/// turned.
std::vector<int> settle_order_by_shape(Correspondences& data, const UsedMask& used, BundleState& state,
                                       const BundleOptions& options);

/// By view: the solution that has not seen it or its pose (first order), its board pose taken from what
/// `judged` names of its first camera alone. nullopt for a view that takes no part, and for one without which
/// the rest is not determined.
std::vector<std::optional<BundleState>> views_held_out(const Correspondences& data, const UsedMask& used,
                                                       const UsedMask& judged, const BundleState& solution,
                                                       const BundleOptions& options);

/// Mean over views (over groups of views that repeat one pose) of the RMS of what `judged` names in a view
/// that the solution has not seen (first order), its board pose taken from its first camera alone. nullopt
/// when no view can be held out.
std::optional<double> predicted_holdout(const Correspondences& data, const UsedMask& used,
                                        const UsedMask& judged, const BundleState& solution,
                                        const BundleOptions& options);

/// Does the second shape, which has more freedom, explain more than noise would? With S the sum of squared residuals in
/// sigmas over what both use, m the freedom that the second one has more and r what is left of theirs: the standard errors by which
///   F = (S_simple - S_general) / m / (S_general / r)
/// exceeds 1, sqrt(2 / m + 2 / r) each. Noise stays below 1 on average, since the prior takes freedom away.
double explained_by_shape(const Correspondences& simple_data, const Solution& simple,
                          const Correspondences& general_data, const Solution& general, double freedom,
                          double freedom_of_general);

/// Is the bend that each view adds large enough to be reported? Errors of detectors that are alike over a view, of micrometres on the sheet,
/// are estimated as flex as well.
bool flexes_visibly(const EstimatedShape& shape, const Points3& printed);

/// And the common shape? Beside a flex, the common bend is solved for in any case.
bool bends_visibly(const EstimatedShape& shape, const Points3& printed);

/// The solution's points against the board as printed, and its sheet.
EstimatedShape measure_shape(const Correspondences& data, const Solution& solution);

}  // namespace procam::calibrate
