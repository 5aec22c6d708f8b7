#pragma once
/// Several stations of one rig in a room: the pose of the rig at each, from known poses, from the surfaces that the stations see
/// in common, or from both.
///
///   const Registration at = register_stations({{"1", {scan_1}}, {"2", {scan_2}}});
///   at.stations[1].pose;                 // station 1's rig from station 2's rig, with covariance
///
/// Unknowns are the poses T_s = world_from_rig of all stations s and the rig's error c (RigModes), which all stations share.
/// A point p of station s and the point q of station t at the pixel where t sees T_s p have the residual
///
///   r = n . (T_s (p - A_s c) - T_t (q - A_t c)),   n = mean of both unit normals, in the world,
///
/// and the solution minimises, over all pairs of stations that overlap,
///
///   sum rho(r^2 / v) + sum e_s^T C_s^-1 e_s + c^T c,   v = variance of both points, e_s = log(T_s T_s,known^-1),
///
/// with Geman and McClure's rho. Normals are those of planes fitted to 17 x 17 pixels, points are means
/// over 5 x 5 along them. The correspondences are found
/// anew in each step (point-to-plane ICP: Chen and Medioni, IVC 10(3), 1992; projective correspondences: Blais and Levine,
/// PAMI 17(8), 1995; normals of both sides: Rusinkiewicz, SIGGRAPH 2019; all pairs in one solve: Pulli, 3DIM 1999).
///
/// Covariance: H^-1 (M + P) H^-1 with H the information, P that of the known poses and of the rig, and M the sum over cubes of
/// 0.1 m of g g^T, where g is a cube's gradient: neighbouring pixels share errors (cluster-robust covariance: Liang and Zeger,
/// Biometrika 73(1), 1986).
/// Variances of points are at least ten times those of independent points, because decoding and lens models have systematic errors.
///
/// Observability: a station may slide where its surfaces move along themselves (one plane, a corridor, a ball). With the
/// information of normals n_s, n_t of independent errors, J_s^T J_t, whose noise averages out, the RMS motion along the normals for a unit
/// motion of the station is sqrt(eigenvalue); below RegistrationOptions::min_normal_motion the direction is unobservable
/// (Gelfand et al., 3DIM 2003). It is named, and comes from the known poses alone, or the registration is refused.
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/geometry/covariance.hpp"
#include "procam/scan/scan.hpp"

namespace procam::scan {

/// The scans of one rig at one position.
struct Station {
  std::string name;
  std::vector<Scan> scans;
  /// Where the rig is known to be; all stations have one, or none. The covariance must be positive definite.
  std::optional<PoseWithCovariance> world_from_rig = {};
};

struct RegistrationOptions {
  bool refine = true;  ///< false: the known poses are kept, and the common surfaces only checked
  /// Without known poses: how far apart two stations may be, radians about the camera's vertical and metres. About the other axes a
  /// fifth of the angle; up and down a quarter of the distance.
  double max_turn = 60 * kDegree, max_move = 1.0;
  double min_overlap = 0.1;  ///< share of the smaller station's points that another must see
  /// RMS motion of the common surfaces along their normals for a unit motion, below which a direction is unobservable.
  double min_normal_motion = 0.03;
  /// Poses that are known less well than this, one standard deviation, are refused where none was given; metres, radians.
  double max_position_sigma = 5e-3, max_angle_sigma = 0.3 * kDegree;
  int max_points = 6000;  ///< of each pair of stations
  int threads = 0;        ///< 0: as many as the machine has. The result does not depend on it
};

struct RegisteredStation {
  std::string name;
  PoseWithCovariance pose;  ///< world_from_rig; without known poses the world is the first station's rig
  /// Directions that only the known pose fixes, in words.
  std::vector<std::string> unobservable;
};

/// Two stations that see surfaces in common.
struct StationPair {
  int first = 0, second = 0;  ///< numbers of the stations
  int points = 0;             ///< common points in the solve
  double overlap = 0;         ///< share of the points of the one that sees less
  double rms = 0;             ///< of the residuals, along the normals, weighted by the robust kernel, metres
};

struct Registration {
  std::vector<RegisteredStation> stations;
  std::vector<StationPair> pairs;
  VecX rig_error;  ///< c; zeros where the poses were kept
  /// Of the left increments of all stations' poses (6 each), then of c.
  MatX covariance;
  /// Median residual over its standard deviation by the light's noise, 1 for Gaussian noise that differs from pixel to pixel.
  double noise_factor = 1;
  bool has_known_poses = false;
  Diagnostics diagnostics;
};

/// Remarks: "unobservable" names the directions that only the known poses fix; "poses_disagree" (the surfaces contradict the known
/// poses by more than their covariance allows; a failure above ten standard deviations), "no_overlap" (a station that only its known
/// pose places).
/// Throws Error(kInput) for known poses that fit only without a usual mistake (exchanged, inverted, in millimetres, given twice),
/// Error(kNotEnoughData) for a station that sees too little of the others, Error(kDegenerate) for an unobservable direction
/// without known poses and for two different alignments that fit alike, Error(kNotConverged), std::invalid_argument for
/// fewer than two stations, stations without scans, and known poses of some stations only.
PROCAM_EXPORT Registration register_stations(const std::vector<Station>& stations,
                                             const RegistrationOptions& options = {});

}  // namespace procam::scan
