#pragma once
/// Views joined into what a calibration needs.
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/core/rig/observation.hpp"

namespace procam::session {

/// One placement of the board: what each device saw or lit of it, in the order of the devices.
struct BoardView {
  std::string name;  ///< the folder's name
  std::vector<Detections> detections;
  std::vector<LightPoint> light_points = {};  ///< by device numbers of join()'s `devices`
  ImageF decoded = {};                        ///< as ViewImage::decoded, for pictures of the view
};

/// What one camera read off one projector's patterns while the board stood in one place.
struct Reading {
  int camera = 0, projector = 0;  ///< device numbers of join()'s `devices`
  Detections in_camera, in_projector;
  std::vector<LightPoint> light_points = {};
};

/// One view of all that its cameras read while its projectors shone one after the other; devices without a
/// reading saw nothing.
///
/// A camera that read several projectors has found each corner several times, in pictures of one print that
/// barely moved: it is one measurement, their mean, with the covariance of one (what moves a corner, blur and
/// the pixels' grid, moves it in all of them). The light was read where each picture had the corner; it is
/// carried to the mean by the homography from the camera's picture to the projector's, which is good for the
/// small part of a pixel that this takes. Throws std::invalid_argument for device numbers that are no camera
/// and projector.
PROCAM_EXPORT BoardView combine(const std::string& name, const std::vector<Device>& devices,
                                const std::vector<Reading>& readings);

/// Correspondences of all views in which a camera sees at least four points, and the others as many as they
/// have. Diagnostics of the detections are kept, their view named; a rejected view is warned of
/// ("view_left_out"). Light points travel with their view. Throws Error(kInput), naming the view, where an
/// image's size is not the device's, and Error(kNotEnoughData) when no view is left.
PROCAM_EXPORT Correspondences join(const Board& board, const std::vector<Device>& devices,
                                   const std::vector<BoardView>& views);

}  // namespace procam::session
