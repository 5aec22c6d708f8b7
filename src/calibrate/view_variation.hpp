#pragma once
/// Private to calibrate: how much differs from view to view beside the board's pose (ViewVariation).
#include "procam/calibrate/result.hpp"
#include "solve.hpp"

namespace procam::calibrate {

/// A start for the search: the sheet rises by half a percent of the print's diagonal over half of it, focal lengths change by
/// 0.1 %, images are displaced by a pixel.
ViewVariation loose_variation(const Points3& printed);

/// Sizes for all of ViewVariation, the state with a start for them.
void free_variation(const ViewVariation& sizes, BundleState& state, BundleOptions& options);

/// What is looked for.
struct MayVary {
  bool sheet = true;   ///< its curvature
  bool images = true;  ///< of the cameras
};

/// That of largest restricted likelihood (Patterson and Thompson, Biometrika 58, 1971), to first order at a solution; the noise's
/// size is estimated with it. Sizes are taken one after the other, the most likely first, as long as each multiplies the
/// likelihood by e^8: less comes by chance once in 10^4 sessions. A displacement and a change of focus can stand for each other: of
/// the two orders the more likely end counts. Views that some device contradicts do not count: one lens that was zoomed once
/// says nothing of the others.
ViewVariation most_likely_variation(const Correspondences& data, const Solution& solution, MayVary may);

/// RMS of what flex lifts the measured points of their views by, after its mean over the view; metres.
double flex_rms(const Correspondences& data, const Solution& solution);

/// By device; zero where nothing changes.
std::vector<ImageChange> image_change_rms(const Correspondences& data, const Solution& solution);

/// How far the change moves pixels, RMS over the views at a usual distance from the image's middle.
double displacement_px(const ImageChange& change, ImageSize image);

}  // namespace procam::calibrate
