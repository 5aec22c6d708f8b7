#pragma once
/// Private to calibrate: the board's own shape.
#include <vector>

#include "procam/calibrate/bundle.hpp"
#include "procam/calibrate/result.hpp"

namespace procam::calibrate {

/// One sigma by which a point of a printed and mounted sheet lies off its place: 1 % of the distance between
/// neighbouring points (J. Strobl and G. Hirzinger, ICCV workshops 2011, let printed boards go free
/// likewise).
double board_sigma(const Points3& printed);

/// Where a board looks the same turned by 180 degrees, its shape does not: turns the order of the views (in
/// `data`, all devices, and the poses in `state`) that fit the shape better so. Returns the views that were
/// turned.
std::vector<int> settle_order_by_shape(Correspondences& data, const UsedMask& used, BundleState& state,
                                       const BundleOptions& options);

/// By view: the solution that has not seen it (first order), its board pose taken from what `judged` names of
/// its first camera alone. nullopt for a view that takes no part, and for one without which the rest is not
/// determined.
std::vector<std::optional<BundleState>> views_left_out(const Correspondences& data, const UsedMask& used,
                                                       const UsedMask& judged, const BundleState& solution,
                                                       const BundleOptions& options);

/// By view: RMS of what `judged` names in it, by the solution that has not seen it (views_left_out).
std::vector<std::optional<double>> predicted_holdout(const Correspondences& data, const UsedMask& used,
                                                     const UsedMask& judged, const BundleState& solution,
                                                     const BundleOptions& options);

/// Means over the views that both predict, and the median view's free over flat; zero, zero and one without
/// such a view.
struct HoldoutGain {
  double flat_px = 0, free_px = 0, usual_ratio = 1;
};
HoldoutGain compare_holdout(const std::vector<std::optional<double>>& flat,
                            const std::vector<std::optional<double>>& free);

/// The state's points against the board as printed.
EstimatedShape measure_shape(const Points3& printed, const Points3& points_in_board);

}  // namespace procam::calibrate
