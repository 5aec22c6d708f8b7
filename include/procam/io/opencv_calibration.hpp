#pragma once
/// Projector-camera calibrations that others left in OpenCV's XML or YAML storage.
///
/// Matrices read: cam_int, cam_dist, proj_int, proj_dist, rotation (or "roration", as one widely copied
/// script spells it), translation, img_shape (rows, columns of the camera's image) and rms. The pose is
/// stereoCalibrate's: x_projector = R x_camera + t. OpenCV counts pixels as procam does, centres at integers.
#include <filesystem>

#include "procam/core/rig.hpp"

namespace procam::io {

/// The rig with frame = camera. The file names neither the projector's size nor the unit of its translation:
/// the caller gives `projector_size` and `metres_per_unit` (0.001 when the board was measured in mm). The
/// file's one RMS becomes that of both devices. Throws Error(kInput) when a matrix is missing, misshapen or
/// not what it should be, Error(kUnsupported) for lens models beyond 8 coefficients, Error(kIo) when the file
/// cannot be read.
Rig load_opencv_calibration(const std::filesystem::path& path, ImageSize projector_size,
                            double metres_per_unit);

}  // namespace procam::io
