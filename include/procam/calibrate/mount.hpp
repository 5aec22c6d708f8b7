#pragma once
/// The pose of the rig on what carries it ("mount"): a robot's base, an arm's flange or a pan-tilt head, from a motion
/// past markers or, on a robot, past walls and over a floor.
///
///   MountData drive;                                   // poses of the base, sightings of markers, in time
///   MountOptions options;
///   options.height = MountHeight{0.85, 0.005};         // a planar drive cannot observe it
///   const MountResult mount = calibrate_mount(drive, options);
///   mount.base_from_rig;                               // with its 6 x 6 covariance
///
/// Unknown are the mount X = base_from_rig, the pose W_m of each marker, the path T(t) of the base, and the
/// offset d of the two clocks. Minimised is
///   sum_i |log(B_i^-1 C T(t_i - d))|^2 / sigma_base^2           poses B_i of the localiser, at its times t_i
/// + sum_j |log(W_m^-1 T(s_j) X M_j^-1)|^2 in C_j^-1             sightings M_j = marker_from_rig, at camera time s_j
/// + sum_k |log(T_k-1^-1 T_k) - log(T_k^-1 T_k+1)|^2 / sigma_a^2 white acceleration between the knots T_k
/// + the same of planes M_j, of which the tilt about x and y and the z of W_m^-1 T(s_j) X M_j^-1 alone count
/// + the priors: height, earlier mount, known markers, floor.
/// T(t) is a constant twist between knots 50 ms apart, in the camera's time: the time offset moves the noisy poses along
/// the knots, not the precise sightings. A fit draws what is precise to the knots, where the path is least stiff, and
/// sightings that move biased the time offset by 1 to 2 ms. The acceleration term is weak and bridges gaps. C is the
/// plane of the floor in the localiser's world (planar motion), and what the localiser jumped by. Solved by Ceres
/// with analytic derivatives (Levenberg-Marquardt).
///
/// Planar motion. Base poses that leave a plane by no more than their noise are taken as planar: tilt and height of T(t)
/// are those of an uneven floor, a first-order Gauss-Markov process of 1 s and small, estimated variance, of which the
/// localiser tells nothing. With free ones, the noise of roll and pitch would look like motion, and the height would
/// seem observable. What the drive cannot observe is read from the information about the mount with all else eliminated
/// (Schur complement): a direction whose standard deviation exceeds MountOptions::max_sigma is unobservable. It is
/// named, and has to be supplied by a stated measurement; without one Error(kDegenerate) states the measurement or
/// the drive that is missing. No value is assumed.
///
/// Planes. A sensor that sees the floor determines roll, pitch and height of a planar drive (MountOptions::floor): the base
/// moves parallel to it. Walls of unknown pose give yaw, x and y by how their distances change with position and heading of the
/// base. Their covariances have a factor of their own, as depth sensors err alike over a whole plane. A sensor's distances
/// may be off in proportion, and the sensor may be turned against the rig (MountPlaneSensor): both are unknowns. Walls and the
/// localiser's metres determine the scale; the turn is that of the mount, unless markers separate them. Their covariance is
/// part of that of the mount. Planes without a name are followed from image to image by
/// their predicted tilt and distance. The floor is the lowest plane that keeps both while the base turns. Planes that lie
/// within each other by the first result are joined, and all is solved again.
///
/// Noise. The standard deviations of the localiser and a factor on those of the sightings are estimated (variance
/// components: W. Foerstner, 1979; the traces by random probes: A. Girard, 1989). Errors of the localiser that stay
/// correlated in time are replaced by white noise of the same power at low frequency (C. Geyer, 1992, initial
/// positive sequence).
///
/// Lengths. A wrong size of the markers, or a wrong wheel, makes the lengths of sightings and poses disagree. Their ratio
/// becomes an unknown where its score is significant, and more so than that of any change.
///
/// Events. For each candidate time two changes are tested by their score (Lagrange multiplier): the rig moved on the
/// base (bump), or the localiser's world moved (jump, wheel slip). The best one that is significant becomes an
/// unknown of the solve; then the next is looked for. Single outliers are rejected by their chi-square.
///
/// Arm (MountCarrier::kFlange). B_i are base_from_flange, X = flange_from_rig, and the W_m are in the arm's base:
/// A X = Z B with several Z. Markers of known pose in a world of their own add world_from_base as an unknown, six
/// directions more, with the joint covariance of both. A recording of stations (MountOptions::stations) has no path
/// between them: each pose is a knot, and there is neither acceleration nor time offset.
///
/// Pan-tilt head (MountCarrier::kHead). T(t) is the pose of the tilting part in the head's frame (core/rig/pan_tilt.hpp):
///   head_from_tilt(p, q) = Rz(p) Tx(a) Rx(alpha) Rz(q),   X = tilt_from_rig
/// by the reported angles p, q. Two lines in space have two invariants, a and alpha; the zero angles and the offsets
/// along the axes are in X and world_from_head (J. Denavit, R. Hartenberg, 1955). T(t_i - d) deviates from
/// head_from_tilt(p_i, q_i) by the noise of the angles, and along the other four directions by the runout of the axes.
/// position_sigma is that runout (metres, and radians 1 m away), rotation_sigma the noise of the angles.
///
/// Sources: F. Park, B. Martin, "Robot sensor calibration: solving AX = XB on the Euclidean group", IEEE TRA 10(5),
/// 1994; H. Zhuang, Z. Roth, R. Sudhakar, "Simultaneous robot/world and tool/flange calibration by solving
/// homogeneous transformation equations of the form AX = YB", IEEE TRA 10(4), 1994 (AX = ZB is the full motion of
/// this solver); R. Tsai, R. Lenz, "A new technique for fully autonomous and efficient 3D robotics hand/eye calibration",
/// IEEE TRA 5(3), 1989 (two axes of rotation are needed); F. Dornaika, R. Horaud, "Simultaneous robot-world and
/// hand-eye calibration", IEEE TRA 14(4), 1998 (all unknowns in one non-linear solve); C. Guo, F. Mirzaei, S. Roumeliotis, "An analytical least-squares solution to the odometer-camera
/// extrinsic calibration problem", ICRA 2012 (planar start values); P. Furgale, J. Rehder, R. Siegwart, "Unified
/// temporal and spatial calibration for multi-sensor systems", IROS 2013 (time offset); T. Barfoot, "State
/// Estimation for Robotics", 2017 (priors of continuous time).
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/error.hpp"
#include "procam/core/base/export.hpp"
#include "procam/core/rig/mount_data.hpp"
#include "procam/core/rig/pan_tilt.hpp"

namespace procam::calibrate {

/// A marker in the world; the covariance is of the left increment, in the world.
struct MountMarker {
  std::string name;
  PoseWithCovariance world_from_marker;
};

/// A plane in the world: z of its frame is the normal. The covariance is of the tilt about its own x and y, and of z.
struct MountPlane {
  std::string name;
  Pose world_from_plane;
  Mat3 covariance = Mat3::Zero();
};

enum class BaseMotion {
  kAuto,    ///< planar if the base poses leave a plane by no more than their noise
  kPlanar,  ///< a robot on a floor
  kFull     ///< six degrees of freedom: ramps, arms, hand-held
};
/// "auto", "planar", "full". Throws Error(kInput).
PROCAM_EXPORT BaseMotion parse_base_motion(const std::string& text);

/// Height of the rig's origin above the base's origin, along the base's z axis; metres.
struct MountHeight {
  double value = 0, sigma = 0;
};

/// The floor of a planar drive, among the planes that are seen.
struct MountFloor {
  std::string plane = "plane_floor";  ///< its name in the data
  double below = 0;                   ///< of the base's origin, metres; 0 for ROS' base_footprint (REP 105)
  /// Of `below`, and of the slope between the floor under the wheels and before the sensor, over a metre.
  double sigma = 0.001;
};

/// By how much the sensor of planes may be off during the whole drive, one standard deviation. 0: it is exact.
struct MountPlaneSensor {
  double scale_sigma = 0.005;         ///< of its distances, in proportion
  double turn_sigma = 0.1 * kDegree;  ///< against the rig about each axis, radians
};

/// What carries the rig.
enum class MountCarrier {
  kBase,    ///< a robot, and its localiser
  kFlange,  ///< an arm: the "base" of the data and the result is the flange, their "world" the arm's base
  kHead     ///< a pan-tilt head: the "base" is its tilting part, the "world" the head
};

struct MountOptions {
  MountCarrier carrier = MountCarrier::kBase;
  BaseMotion motion = BaseMotion::kAuto;  ///< of a robot
  /// The carrier stood still at each pose; a sighting belongs to the pose nearest in time. Then no path is modelled,
  /// and the time offset is as stated.
  bool stations = false;
  double station_time = 0.5;                ///< a sighting further from any station is not used, seconds
  std::optional<MountHeight> height;        ///< as measured
  std::optional<MountFloor> floor;          ///< of a planar drive
  std::optional<PoseWithCovariance> prior;  ///< base_from_rig as known before (drawing, earlier calibration)
  /// Markers of known pose: for a robot in the localiser's world; for an arm and a head in a world of their own, and
  /// MountResult::world_from_base is estimated.
  std::vector<MountMarker> markers;
  bool estimate_time_offset = true;  ///< else `time_offset` is exact
  double time_offset = 0;            ///< start value, seconds (MountResult::time_offset)
  double max_time_offset = 1;        ///< searched about the start value, seconds
  /// Of the localiser: start values, or exact if estimate_noise is false. Metres, each axis of the world; radians,
  /// about each axis of the base. Of an arm and a head the estimates are at least these: state them as they are
  /// known (repeatability; step of the angles / sqrt(12)).
  double position_sigma = 0.01, rotation_sigma = 0.01;
  bool estimate_noise = true;
  /// White acceleration of the base, one standard deviation of the change of speed in a second: m/s, rad/s. Too loose,
  /// and the noise of the path biases the time offset; too stiff, and braking looks like a jump.
  double acceleration = 0.1, turn_acceleration = 0.2;
  /// How uneven the floor is under a planar base: start values, or exact if estimate_noise is false. Metres, radians.
  double floor_sigma = 0.0003, floor_tilt_sigma = 0.0003;
  MountPlaneSensor plane_sensor;
  /// A direction of the mount is unobservable from this standard deviation on: metres, and radians (1 m away).
  double max_sigma = 0.1;
  bool find_events = true;   ///< bumps of the rig, jumps of the localiser
  double event_chi2 = 60;    ///< of a change's score, 6 or 3 degrees of freedom
  double event_size = 2e-3;  ///< smallest change that is looked for, metres, or radians 1 m away
};

/// A change during the drive.
struct MountEvent {
  enum class Kind {
    kRigBumped,  ///< change = base_from_rig after, times the inverse of before
    kLocaliserJumped  ///< change = reported pose after, times the inverse of before: jump of the map, or wheel slip
  };
  Kind kind = Kind::kRigBumped;
  double time = 0;  ///< localiser's clock
  Pose change;
  double chi2 = 0;        ///< by which the fit improves, to first order
  double other_chi2 = 0;  ///< the same of the other kind, at its best time
};

/// One of the directions of the mount: rotation about the base's axes at the rig's origin, position of that
/// origin on the base; and the two invariants of a head's axes.
struct MountDirection {
  /// "roll", "pitch", "yaw", "x", "y", "height"; of an arm "z"; of a head "roll", "pitch", "tilt zero", "x", "y", "z",
  /// "axis offset", "axis angle".
  std::string name;
  double sigma = 0;       ///< radians, metres
  double sigma_data = 0;  ///< from the drive alone; infinite if it does not depend on it at all
  bool observable = true;
};

struct MountResult {
  MountCarrier carrier = MountCarrier::kBase;
  /// After the last bump, if there was one. The covariance is of the left increment [rotation, translation] in the
  /// base's frame.
  PoseWithCovariance base_from_rig;
  std::vector<MountDirection> directions;  ///< in the order of MountDirection::name
  std::optional<PanTiltAxes> axes;         ///< of a head
  /// Of an arm's base or a head; nullopt without markers of known pose. Covariance of the left increment, in the world.
  std::optional<PoseWithCovariance> world_from_base;
  /// Of base_from_rig [rotation, translation], then `axes` [offset, angle], then world_from_base, as far as they are
  /// there: 6 to 14 rows.
  MatX joint_covariance;
  /// Localiser time = camera time + time_offset: positive if the localiser's stamps are late against the camera's.
  double time_offset = 0, time_offset_sigma = 0;
  /// Lengths of the localiser (an arm) over those of the sightings; 1 and sigma 0 where no difference is significant.
  /// The mount and the path are in the metres of the sightings.
  double scale = 1, scale_sigma = 0;
  /// What the sensor of planes is off by.
  struct PlaneSensor {
    /// Reported distances over those in the metres of the markers, or of the localiser where there are no markers.
    double scale = 1;
    Vec3 turn = Vec3::Zero();  ///< rotation vector in the rig: true rig_from_plane = exp(turn) * reported
    Mat4 covariance = Mat4::Zero();  ///< of the scale and the turn
  };
  std::optional<PlaneSensor> plane_sensor;  ///< where planes are seen
  std::vector<MountMarker> markers;         ///< all that were seen, by name
  std::vector<MountPlane> planes;           ///< likewise
  bool planar = false;
  std::vector<BasePose> path;                     ///< estimated, at the knots
  double position_sigma = 0, rotation_sigma = 0;  ///< of the localiser, estimated
  double correlation = 1;                         ///< variance at low frequency over that of white noise
  double sighting_factor = 1;  ///< on the stated standard deviations of the markers' sightings
  double plane_factor = 1;     ///< the same of the planes'
  double floor_sigma = 0, floor_tilt_sigma = 0;  ///< of an uneven floor, estimated; planar
  std::size_t sightings_used = 0, base_poses_used = 0;
  std::vector<std::size_t> rejected_sightings, rejected_base_poses;  ///< indices into the data
  std::size_t sightings_outside = 0;                                 ///< at times without base poses
  std::vector<MountEvent> events;
  Diagnostics diagnostics;

  /// Names of the directions that the drive cannot observe.
  std::vector<std::string> unobservable() const {
    std::vector<std::string> names;
    for (const MountDirection& direction : directions)
      if (!direction.observable) names.push_back(direction.name);
    return names;
  }
};

/// Remarks: "stated_not_observed" names the directions that come from a stated measurement, "sightings_rejected",
/// "base_poses_rejected", "rig_bumped", "localiser_jumped", "event_unclear" (the two kinds cannot be separated),
/// "correlated_localiser", "sightings_noisier", "planes_noisier" (the stated covariances are too small), "time_offset_weak",
/// "plane_sensor_off" (MountResult::PlaneSensor, beyond three times what was stated), "statement_disagrees" (the stated height or prior contradicts the drive), "lengths_disagree" (MountResult::scale),
/// "poses_noisier" (an arm or a head scatters more than stated). Failures: "too_many_changes", and "lengths_disagree"
/// where the mount may be off by more than 5 mm.
///
/// Throws Error kNotEnoughData (too few poses or sightings, no overlap in time), kDegenerate (an unobservable
/// direction without a stated measurement; a base that does not turn; most poses or sightings contradict the others),
/// kNotConverged, kInput (a name that is a marker and a plane; a floor that is not seen; times that do not grow; poses that are inverted, in millimetres or in another quaternion order);
/// std::invalid_argument for numbers that are not finite or sigmas that are not positive.
PROCAM_EXPORT MountResult calibrate_mount(const MountData& data, const MountOptions& options = {});

}  // namespace procam::calibrate
