#pragma once
/// A rig in the calibration formats of other programs. The way back is load_calibration() (calibration_file.hpp).
///
///   const ForeignCalibration camera_info = export_calibration(CalibrationFormat::kRos, rig, "camera");
///   write_file_atomically("camera.yaml", camera_info.text);
///
/// | format | holds | does not hold | pixel (0, 0) |
/// |---|---|---|---|
/// | opencv | one device: K, distortion, size | poses; OpenCV's functions ignore skew | centre of the first |
/// | opencv-stereo | two devices (M1 D1 M2 D2), x_2 = R x_1 + T | names, and which is a camera | centre |
/// | ros | one device as camera_info: K, D, R, P | poses; image_geometry ignores skew | centre |
/// | kalibr | all devices as camchain, with T_cn_cnm1 | skew, k3, rational lenses, names | centre |
/// | mrcal | one device, its pose as rt_cam_ref, the rig as reference | skew, fisheye lenses (refused) | centre |
/// | colmap | cameras.txt of all devices | skew, poses, names | corner: cx, cy are 0.5 larger |
/// | urdf, sdf | the frames of all devices, fixed to the frame "rig"; with a mount that on its base, and a head's joints | intrinsics | - |
/// | gltf | nodes and perspective cameras for a scene | lens, skew, principal point | - |
///
/// No format but procam's own holds the covariance. Each loss is a warning or a note of `diagnostics`, with its size in
/// pixels: the largest distance, over the image, between the pixel of a ray by the rig and by the format.
///
/// Sources: OpenCV's calibration and stereo samples; sensor_msgs/CameraInfo; Kalibr's "YAML formats"; mrcal's
/// "Camera model file formats"; COLMAP's "Output format" and "Camera models"; URDF's XML specification (rpy: fixed
/// axes x, y, z); SDFormat 1.9; glTF 2.0, 3.10.3.
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/io/pose_file.hpp"

namespace procam::io {

enum class CalibrationFormat { kOpenCv, kOpenCvStereo, kRos, kKalibr, kMrcal, kColmap, kUrdf, kSdf, kGltf };

/// "opencv", "opencv-stereo", "ros", ... as in the table. Throws Error(kInput) that suggests the nearest.
PROCAM_EXPORT CalibrationFormat parse_calibration_format(const std::string& name);

struct ForeignCalibration {
  std::string text;
  /// Warnings "skew_lost", "lens_lost", "skew_ignored", "frustum_centred"; notes "poses_lost", "intrinsics_lost",
  /// "names_lost", "name_changed", "kinds_lost", "world_lost", "covariance_lost".
  Diagnostics diagnostics;
};

/// `device` names the camera or projector to write; empty: all, or the only one for a format of one device. Throws
/// Error(kInput) when the rig has several then, or none of that name, and for a stereo pair of other than two devices;
/// Error(kUnsupported) for a lens that the format has no model for. `mount`: of the rig on its robot, for urdf and sdf;
/// Error(kInput) for another format, and for a mount of something else than the rig or one of its devices.
PROCAM_EXPORT ForeignCalibration export_calibration(CalibrationFormat format, const Rig& rig,
                                                    const std::string& device = "",
                                                    const std::optional<Mount>& mount = std::nullopt);

}  // namespace procam::io
