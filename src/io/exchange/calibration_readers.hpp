#pragma once
/// Formats of load_calibration() with a syntax, or with names of their numbers, of their own.
#include <optional>
#include <string>
#include <string_view>

#include "document/value.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/io/exchange/calibration_file.hpp"

namespace procam::io {

/// mrcal's .cameramodel: a Python literal with the member 'lensmodel', or 'lens_model' in old files.
bool is_mrcal(std::string_view bytes);
/// The camera, its pose from rt_cam_ref ('extrinsics'): the rig is mrcal's reference. Throws Error(kInput), and
/// Error(kUnsupported) for the lens models CAHVOR, CAHVORE, STEREOGRAPHIC, LONLAT, LATLON, SPLINED and OPENCV12.
Rig read_mrcal(std::string_view bytes, const std::string& file);

/// COLMAP's cameras.txt: lines of "ID MODEL WIDTH HEIGHT PARAMS".
bool is_colmap(std::string_view bytes);
/// The file's only camera: several without poses make no rig. COLMAP counts pixels from the corner of the first one, so
/// cx and cy are 0.5 smaller here. Throws as above.
Rig read_colmap(std::string_view bytes, const std::string& file);

/// Cameras of glTF scenes, with their nodes' poses, and the one camera of an SDF model. nullopt for any other document.
/// Throws Error(kInput), and Error(kUnsupported) for URDF models and SDF models of several cameras.
std::optional<Rig> read_scene(const Value& root, const CalibrationContext& context);

/// Cameras of programs that list each number by name: ORB-SLAM, camodocal (VINS), nerfstudio, Open3D, librealsense,
/// Metashape. nullopt for any other document. Throws Error(kInput), and Error(kUnsupported) for lens models that procam
/// does not have.
std::optional<Rig> read_named(const Value& root, const CalibrationContext& context);

}  // namespace procam::io
