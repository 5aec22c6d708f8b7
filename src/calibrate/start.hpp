#pragma once
/// Private to calibrate: from correspondences alone to a state that the bundle adjustment converges from.
#include <optional>
#include <string>
#include <vector>

#include "procam/calibrate/bundle.hpp"
#include "procam/calibrate/options.hpp"

namespace procam::calibrate {

struct Start {
  BundleState state;
  UsedMask used;   ///< measurements of usable views
  UsedMask first;  ///< of them, those of views that agree about every device: what to begin with
  BundleOptions bundle_options;
  std::vector<bool> view_used;
  std::vector<std::string> notes;  ///< by view, for people
  Diagnostics diagnostics;
  ViewVariation variation = {};  ///< where the search for it begins; none: anywhere
};

/// Each camera by Zhang and a bundle of its own. Then the rig grows from the first camera: a camera that
/// shares a view with those that stand is placed by it, a projector that lights three posed views is resected
/// linearly, and each poses the views that nobody had posed. Where the board looks the same turned by 180
/// degrees, the order of each device's points is settled by the residual and turned in `data`. Throws
/// Error(kNotEnoughData) for devices that no view joins, naming them.
Start find_start(Correspondences& data, const std::optional<KnownLens>& known_camera, const Options& options);

}  // namespace procam::calibrate
