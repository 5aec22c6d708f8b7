#pragma once
/// Private to calibrate: why a view disagrees with the others, in words that tell what to do.
#include <optional>
#include <string>
#include <vector>

#include "solve.hpp"

namespace procam::calibrate {

/// Tries, in this order: light of another view (stale frames), the order of points turned or mirrored, a
/// board (or a device) that moved between the frames, and else a view of something else.
std::string cause_of_disagreement(const Correspondences& data, const UsedMask& everything,
                                  const Solution& solution, int view, int device);

/// A view that a projector rejects without a cause that the frames of one capture can have: the camera's image itself may be
/// of another lens position, another orientation or another board.
struct ForeignView {
  std::size_t view = 0;
  std::string cause;
};
/// Those that one camera alone poses. None where they are more than a third of the views.
std::vector<ForeignView> views_of_another_capture(const Correspondences& data, const UsedMask& everything,
                                                  const Solution& solution);

/// Do the corners that a view's camera saw fit its lens in `others`, the solution without that view, as well as those of other
/// views do? `all`: the solution with it, from which the board's pose begins.
bool agrees_with_camera(const Correspondences& data, const UsedMask& everything, const Solution& all,
                        const Correspondences& other_data, const Solution& others, std::size_t view);

/// Views of one device that were all rejected because its pose or its lens differs from that in the others, by the same in
/// all of them.
struct ChangedDevice {
  bool of_lens = false;     ///< zoomed, refocused or shifted; else it moved against the rig
  std::string description;  ///< with what to do
};
/// The change that fits the views better, of the pose or of the lens; nullopt where neither explains them.
std::optional<ChangedDevice> changed_device(const Correspondences& data, const UsedMask& everything,
                                            const Solution& solution, int device);

/// A periodic pattern in a projector's residuals: its picture is resampled between the cable and the light
/// (another resolution than its own, keystone, overscan), which moves pixels to and fro by parts of one.
/// Empty when there is none.
std::string resampled_picture(const Correspondences& data, const Solution& solution, int device);

}  // namespace procam::calibrate
