#pragma once
/// The recordings of a drive -> MountData for calibrate::calibrate_mount().
///
///   session::MountFiles files;
///   files.base = "base.log";            // frame "map", child "base": a pose log or a trajectory of another program
///   files.sightings = "sightings.log";  // frame "marker_3" or "plane_floor", child "rig": a pose log with covariances
///   const session::MountRecording drive = session::read_mount_data(files);
///   calibrate::calibrate_mount(drive.data);
///
/// Times are those of the stamps where every message has one, else the arrivals; the calibration estimates the
/// difference of the two clocks. A frame whose name begins with "plane_" is a plane (MarkerSighting::is_plane). A pose log may hold other frames as well (`project-live --record`): they are skipped.
#include <filesystem>
#include <string>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/board/marker.hpp"
#include "procam/core/rig/mount_data.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam::session {

struct MountFiles {
  std::string base;    ///< a pose log, or a trajectory (track/trajectory_file.hpp)
  std::string angles;  ///< or of a pan-tilt head: a log of angles (track/head_angles.hpp)
  std::string sightings;
  std::string child = "base", rig = "rig";  ///< names of the base and the rig in the logs
};

struct MountRecording {
  MountData data;
  std::string world;              ///< frame of the base's poses
  std::vector<InputFile> inputs;  ///< with their digests
  Diagnostics diagnostics;
};

/// Remarks: "poses_out_of_order" (base poses that are not after those before them are dropped), "poses_repeated" (most
/// poses equal the one before, bit for bit: the repeated ones are dropped), "clock_jumped" (stamps against arrivals),
/// "arrival_times" (a log without stamps). Throws Error kIo, kInput (a
/// sighting without covariance; a log without the frames), kNotEnoughData.
PROCAM_EXPORT MountRecording read_mount_data(const MountFiles& files);

/// A folder of images of single markers, each file called after its time.
struct SightingImages {
  std::filesystem::path folder;
  MarkerDictionary dictionary = MarkerDictionary::kAprilTag36h11;
  double size = 0;  ///< of each marker: side of the black square, metres
};
/// Images of single markers -> sightings. Each file is called after its time: seconds ("12.35.png"), or nanoseconds above
/// 1e14 ("1403636579763555584.png"), as EuRoC and TUM name theirs. A marker is named "marker_ID".
/// Images without markers are skipped, as are sightings whose second pose (the mirror image
/// of a flat view) is not excluded. Throws Error kIo, kInput, kNotEnoughData (no marker in any image).
PROCAM_EXPORT std::vector<MarkerSighting> sightings_in_images(const SightingImages& images,
                                                              const RigCamera& camera);

}  // namespace procam::session
