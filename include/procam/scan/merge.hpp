#pragma once
/// The scans of registered stations -> one cloud and one mesh.
///
/// Where several stations see one surface, a pixel's depth is the mean of theirs along its ray, each weighted by the inverse variance
/// of its noise (the others' by the plane through the point at the pixel where they see it). Each part of a surface is then kept
/// from the station that sees it best, z^2 / cos(incidence), so that no wall is double. The rig's error that the registration
/// estimated is removed from all scans first.
///
/// Standard deviations: the fused noise; and, as Scan::rig_sigma, sqrt(J C J^T) with the joint covariance C of the stations' poses
/// and of the rig's error, J that of the weighted mean along the surface's normal.
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/mesh.hpp"
#include "procam/core/geometry/point_cloud.hpp"
#include "procam/scan/scan_mesh.hpp"
#include "procam/scan/stations.hpp"

namespace procam::scan {

struct MergeOptions {
  MeshOptions mesh;
  /// Points of two stations are on one surface when they are this many standard deviations apart or less along the normal ...
  double max_sigmas = 5;
  double max_distance = 1e-3;  ///< ... or this many metres
  int threads = 0;             ///< 0: as many as the machine has. The result does not depend on it
};

/// One scan of one station, in the world.
struct FusedScan {
  int station = 0;
  Scan scan;  ///< camera.rig_from_camera is world_from_camera; all measured pixels, fused
  Scan kept;  ///< the same, of the surfaces that no other station sees better
};

struct MergedStations {
  std::vector<FusedScan> scans;
  /// Kept points in the world; sigma is along the normal, of noise, poses and rig.
  PointCloud cloud;
  std::vector<int> cloud_station;  ///< of each point of the cloud: the station that sees it best
  /// In the world. Content coordinates are longitude and latitude as seen from the first station's camera, (0, 0) .. (1, 1) over the
  /// mesh.
  Mesh mesh;
  double fused_share = 0;   ///< of the pixels: seen by two stations or more
  double gap_before = 0;    ///< RMS distance of the stations' surfaces along the normal, metres
  double gap_expected = 0;  ///< the same by the stated standard deviations
  int contradictions = 0;   ///< pixels whose point another station sees through
  Diagnostics diagnostics;
};

/// Remark: "contradictions" (something stood elsewhere at another station; above a fifth of the points a failure).
/// Throws std::invalid_argument for a registration of other stations, Error(kNotEnoughData) as mesh_of() does.
PROCAM_EXPORT MergedStations merge_stations(const std::vector<Station>& stations,
                                            const Registration& registration,
                                            const MergeOptions& options = {});

}  // namespace procam::scan
