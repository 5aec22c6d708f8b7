#pragma once
/// Private to calibrate: bundle adjustment in rounds, until noise, outliers and views that disagree have
/// settled.
#include <string>
#include <vector>

#include "procam/calibrate/bundle.hpp"
#include "procam/calibrate/options.hpp"

namespace procam::calibrate {

struct Solution {
  BundleResult bundle;
  UsedMask used;
  BundleOptions options;  ///< with the noise that the residuals showed
  /// rejected[view][device]: the whole view disagrees with the others in that device.
  std::vector<std::vector<char>> rejected;

  const BundleState& state() const { return bundle.state; }
};

/// Begins with the measurements in `first` and decides about all in `all`.
/// Throws Error(kNotConverged) when the last round does not converge, Error(kDegenerate) when fewer than
/// three views of a device agree.
Solution solve(const Correspondences& data, const BundleState& start, const BundleOptions& bundle_options,
               const UsedMask& first, const UsedMask& all, const Options& options);

/// Does any measurement of the view take part?
bool takes_part(const UsedMask& used, std::size_t view);

/// The first camera with measurements in a view, other than one device; -1 when there is none. It is what the
/// view's board pose is taken from where another device is to be predicted.
int posing_camera(const Correspondences& data, const UsedMask& used, std::size_t view, int other_than = -1);

/// Nothing but one view of a mask; with a device, nothing but that device's part of it.
UsedMask only_view(const UsedMask& used, std::size_t view, int device = -1);

/// The same options with everything held that views share: lenses, device poses, the board's points.
BundleOptions hold_devices(BundleOptions options, const BundleState& state);

/// RMS of |residual| over the used measurements; of one view and one device where these are given.
struct Spread {
  double rms_px = 0;
  int count = 0;
};
Spread spread_of(const Correspondences& data, const BundleState& state, const UsedMask& used, int device = -1,
                 int view = -1);

}  // namespace procam::calibrate
