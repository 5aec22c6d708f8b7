#pragma once
/// Private to calibrate: why a view disagrees with the others, in words that tell what to do.
#include <string>

#include "solve.hpp"

namespace procam::calibrate {

/// Tries, in this order: light of another view (stale frames), the order of points turned or mirrored, a
/// board (or a device) that moved between the frames, and else a view of something else.
std::string cause_of_disagreement(const Correspondences& data, const UsedMask& everything,
                                  const Solution& solution, int view, int device);

/// Views of one device that were all rejected because its pose differs from that in the others, at one
/// place in all of them: the device moved against the rig. Empty when that is not what happened.
std::string moved_device(const Correspondences& data, const UsedMask& everything, const Solution& solution,
                         int device);

/// A periodic pattern in a projector's residuals: its picture is resampled between the cable and the light
/// (another resolution than its own, keystone, overscan), which moves pixels to and fro by parts of one.
/// Empty when there is none.
std::string resampled_picture(const Correspondences& data, const Solution& solution, int device);

}  // namespace procam::calibrate
