#pragma once
/// A calibration from a file: procam's rig.json, or what another program wrote. The contents decide, not the
/// name: JSON, YAML, or OpenCV's XML.
///
/// | written by | read |
/// |---|---|
/// | procam | rig.json, all of it |
/// | OpenCV's calibration sample | camera_matrix, distortion_coefficients, image_width, image_height; fisheye_model |
/// | OpenCV's stereo sample | M1 D1 M2 D2 with R T, in one file or in extrinsics.yml beside it; from
///   export_calibration() with size1, size2, metres_per_unit |
/// | ROS (camera_info files and messages) | camera_matrix, distortion_model, distortion_coefficients; K and D |
/// | mrcal (.cameramodel) | lensmodel PINHOLE, OPENCV4, OPENCV5, OPENCV8; its pose, the reference as the rig |
/// | COLMAP (cameras.txt) | one camera: PINHOLE, OPENCV, FULL_OPENCV, OPENCV_FISHEYE, (SIMPLE_)RADIAL(_FISHEYE); cx and
///   cy less 0.5, as COLMAP counts from the corner of the first pixel |
/// | glTF 2.0 (.gltf) | perspective cameras with their nodes' poses; their sizes from `camera_size`, or as export_calibration()
///   states them |
/// | SDF | the sensor of one camera: its field of view or intrinsics, distortion; its pose is not read |
/// | Kalibr (camchain) | cam0, cam1, ...: intrinsics, distortion_model, distortion_coeffs, resolution, T_cn_cnm1 |
/// | projector-camera programs | cam_int cam_dist proj_int proj_dist rotation translation img_shape; or
///   cam_K cam_kc proj_K proj_kc R T |
/// | people | K (3 x 3, or fx fy cx cy), D, size; or such a camera and projector with R and T |
///
/// All others count pixels as procam does, centres at integers, and keep K = [fx skew cx; 0 fy cy; 0 0 1].
/// Distortion is in OpenCV's order k1 k2 p1 p2 k3 k4 k5 k6 (plumb_bob, radtan, rational_polynomial), or
/// k1 k2 k3 k4 of the equidistant fisheye. Poses: R, T and T_cn_cnm1 take points of the first (previous)
/// device's frame to the second's (this one's): x_2 = R x_1 + T. Kalibr's lengths are metres.
#include <filesystem>
#include <optional>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam::io {

/// What other programs' files do not state.
struct CalibrationContext {
  std::optional<ImageSize> camera_size, projector_size;  ///< used where the file has none
  double metres_per_unit = 0.001;  ///< of T where the file has no unit: the board's unit when it was made
};

/// The rig, its frame that of the first camera. Of two devices the second is the projector (two cameras of
/// a stereo calibration too: whoever checks a projector calibrated it as one). One RMS for both becomes that
/// of each. Throws Error(kInput) naming file, line and field where something is missing or not what it should
/// be, Error(kUnsupported) for lens models that procam has not, Error(kIo).
PROCAM_EXPORT Rig load_calibration(const std::filesystem::path& path, const CalibrationContext& context = {});

/// One camera for images of `size`: "fx,fy,cx,cy" or "fx,fy,cx,cy,skew" in pixels, without distortion, or a file
/// as above, in which `name` may be empty when it holds one camera. Throws Error as load_calibration() does, and
/// Error(kInput) for numbers that no camera has and for a camera of another size.
PROCAM_EXPORT RigCamera load_camera(const std::string& text, const std::string& name, ImageSize size);

}  // namespace procam::io
