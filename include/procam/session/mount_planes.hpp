#pragma once
/// Depth images of a drive -> sightings of planes for calibrate::calibrate_mount().
///
///   session::DepthImages depth;
///   depth.folder = "depth";     // 12.35.png, 12.45.png, ...
///   const session::PlaneSightings seen = session::planes_in_depth(depth, rig.camera("depth"));
///   drive.data.sightings = seen.sightings;
///
/// Of each image the planes are found (depth/planes.hpp). A sighting is plane_from_rig with the origin in the middle of the
/// plane's readings, and has no name: the calibration finds out which sightings are of one plane. Planes that are known to
/// 2 degrees or 30 mm, or worse, are omitted.
#include <filesystem>
#include <string>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/rig/mount_data.hpp"
#include "procam/core/rig/rig.hpp"
#include "procam/session/reader.hpp"

namespace procam::session {

/// A folder of depth images, each called after its time: seconds ("12.35.png"), or nanoseconds above 1e14.
struct DepthImages {
  std::filesystem::path folder;      ///< 16 bits (.png, .tif), or floats in metres (.tif, .pfm)
  double metres_per_unit = 0.001;    ///< of 16-bit numbers
  std::string sensor = "kinect-v1";  ///< depth::sensor_kind()
};

/// Planes without names, each at its time.
struct PlaneSightings {
  std::vector<MarkerSighting> sightings;
  std::size_t images = 0, images_without_plane = 0;
  Diagnostics diagnostics;
};

/// The camera of the first image of such a folder has this size. Throws as planes_in_depth().
PROCAM_EXPORT ImageSize depth_image_size(const DepthImages& images);

/// `camera` is the depth camera in its rig. Warns ("sensor_model") where the noise is not that of the sensor. Throws Error
/// kIo, kInput (a name that is no time, an image of another size, a wrong unit), kNotEnoughData (no plane in any image).
PROCAM_EXPORT PlaneSightings planes_in_depth(const DepthImages& images, const RigCamera& camera,
                                             const ReadingProgress& progress = {});

}  // namespace procam::session
