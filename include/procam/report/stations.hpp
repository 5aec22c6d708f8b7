#pragma once
/// Several stations of a rig for people: as JSON, as lines, as a picture.
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/base/image.hpp"
#include "procam/scan/merge.hpp"
#include "procam/scan/scan_error.hpp"

namespace procam::report {

/// Where the truth is known.
struct StationError {
  double position = 0, angle = 0;  ///< metres (of the rig's origin), radians
  /// Square root of e^T C^-1 e / 6 with the stated covariance: about 1. 0 for a fixed pose.
  double in_sigmas = 0;
  double largest_in_sigmas = 0;  ///< of the six elements of e, each by its own standard deviation
  double single_rms =
      0;  ///< of this station's points alone, by its true pose, along the true normals, metres
};

struct StationsReport {
  scan::Registration registration;
  scan::MergedStations merged;
  std::vector<StationError> true_pose_errors;  ///< by station, or none
  std::optional<scan::ScanError> true_error;   ///< of the merged points
};

/// The estimated pose against the true one.
PROCAM_EXPORT StationError pose_error(const PoseWithCovariance& world_from_rig,
                                      const Pose& true_world_from_rig);

/// "stations" (pose, 6x6 covariance row by row, unobservable directions), "pairs", "merged", and the true errors; metres, radians.
PROCAM_EXPORT std::string to_json(const StationsReport& report);

PROCAM_EXPORT std::vector<std::string> lines(const StationsReport& report);

/// The merged points as seen from behind the stations, shaded, with a colour for each station; beside it the standard deviation along
/// the normals. RGB.
PROCAM_EXPORT ImageU8 stations_picture(const scan::MergedStations& merged);

}  // namespace procam::report
