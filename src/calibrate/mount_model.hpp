#pragma once
/// Private to calibrate: the unknowns of calibrate_mount, their solve, and the solve's linear equations.
#include <Eigen/Sparse>
#include <memory>
#include <string>
#include <vector>

#include "mount_costs.hpp"
#include "procam/calibrate/mount.hpp"

namespace procam::calibrate::mount {

/// Rows of the residuals by what made them: the variance components. Of a head kBaseTurn are its angles, kBasePosition
/// the runout of its axes.
enum Group {
  kBaseTurn,
  kBasePosition,
  kBaseTilt,
  kBaseHeight,
  kSighting,
  kPlane,
  kMotion,
  kFloorTilt,
  kFloorHeight,
  kOther,
  kGroups
};

struct Noise {
  double position = 0.01, turn = 0.01;  ///< of the localiser: in the plane if the motion is planar
  double height = 0.01, tilt = 0.01;    ///< off the plane; equal to the above in full motion
  double sighting = 1, plane = 1;       ///< factors on the stated sigmas
  double motion = 1;                    ///< factor on the acceleration
  double floor = 0, floor_tilt = 0;     ///< of an uneven floor under a planar base
  double correlation = 1;               ///< factor on the localiser's variance
};

/// A block that holds from a time on.
struct Epoch {
  double from = 0;  ///< clock of its data: localiser's for a frame, camera's for a mount
  PoseBlock pose{};
};

struct Model {
  const MountData* data = nullptr;
  const MountOptions* options = nullptr;
  bool planar = false;
  /// Times of the base poses, camera's clock, where each is a station of its own and a knot. Else empty.
  std::vector<double> stations;
  std::optional<std::array<double, 2>> axes;  ///< of a head: PanTiltAxes
  std::optional<PoseBlock> world;  ///< world_from_base of an arm or a head, from markers of known pose
  /// Knots are in the camera's time. Between knots the path is stiffer than at them: were the precise sightings to move
  /// along the knots with the time offset, the fit would draw them to the knots.
  double start = 0, spacing = 0.05;
  std::vector<PoseBlock> knots;
  std::vector<Epoch> frames, mounts;      ///< the first of each from the beginning
  std::vector<std::string> marker_names;  ///< sorted
  std::vector<PoseBlock> markers;
  std::vector<char> is_plane;  ///< by marker
  std::vector<int> marker_of;  ///< by sighting
  double offset = 0;
  /// Reported position = scale * position in the metres of the sightings. Exactly 1 until lengths are seen to disagree.
  double scale = 1;
  bool estimates_scale = false;
  std::array<double, 4> sensor{1, 0, 0, 0};  ///< PlaneSensor: scale, rotation vector
  Noise noise;
  /// At the start a sighting counts no more than a pose of the localiser: else the path, which follows the precise
  /// sightings, would follow the wrong ones too.
  bool coarse = true;
  std::vector<char> use_base, use_sighting;

  /// The knot before a time, the next one, and the share of the way to it; nullopt outside. At a station the knot
  /// itself: `next` is any other.
  struct At {
    std::size_t knot, next;
    double alpha;
  };
  std::optional<At> at(double camera_time) const;
  Pose path(double camera_time) const;       ///< at the ends, the first and last knot
  double knot_time(std::size_t knot) const;  ///< camera's clock
  double end() const { return knot_time(knots.size() - 1); }
  std::size_t epoch(const std::vector<Epoch>& epochs, double time) const;
};

/// The equations at the solution: J, r of the whitened residuals (with robust weights if the solve had them). The
/// columns of the last mount (6), the axes of a head (0 or 2) and the time offset (0 or 1) come last.
struct Linear {
  Eigen::SparseMatrix<double> jacobian;
  VecX residuals;
  std::vector<Group> group;                 ///< by row
  std::vector<int> base_row, sighting_row;  ///< first row of each base pose and sighting; -1: not used
  /// First column of each marker (6 of them) and plane (3); -1 where no sighting is left.
  std::vector<Eigen::Index> marker_column;
  Eigen::Index after_markers = 0;              ///< the column after the last of them
  Eigen::Index world_column = -1;              ///< of world_from_base
  Eigen::Index scale_column = -1;              ///< of Model::scale
  Eigen::Index sensor_column = -1;             ///< of Model::sensor
  Eigen::Index mount_column = 0, columns = 0;  ///< of the last mount
  MatX prior_information;  ///< of what the stated measurements say of the last mount (6 x 6)
  VecX prior_gradient;
};

class MountProblem {
 public:
  /// Refers to the model's blocks.
  MountProblem(Model& model, bool robust);
  ~MountProblem();
  /// Until a step changes the cost by less than this share. Throws Error(kNotConverged).
  void solve(double tolerance);
  Linear linearise();
  /// Derivative of a base pose's or sighting's residual, whitened and with its robust weight: by the frame of the
  /// localiser (right increments), by its scale, and by the mount (its directions).
  Mat6 by_frame(std::size_t base) const;
  Vec6 by_scale(std::size_t base) const;
  Mat6 by_mount(std::size_t sighting) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace procam::calibrate::mount
