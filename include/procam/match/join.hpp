#pragma once
/// Views joined into what a calibration needs.
#include <string>
#include <vector>

#include "procam/core/observation.hpp"

namespace procam::match {

/// One placement of the board: what each device saw or lit of it, in the order of the devices.
struct BoardView {
  std::string name;  ///< the folder's name
  std::vector<Detections> detections;
  std::vector<LightPoint> light_points = {};  ///< by device numbers of join()'s `devices`
};

/// Correspondences of all views in which the first device sees at least four points, and the others as many
/// as they have. Diagnostics of the detections are kept, their view named; a view left out is warned of
/// ("view_left_out"). Light points travel with their view. Throws Error(kInput), naming the view, where an
/// image's size is not the device's, and Error(kNotEnoughData) when no view is left.
Correspondences join(const Board& board, const std::vector<Device>& devices,
                     const std::vector<BoardView>& views);

}  // namespace procam::match
