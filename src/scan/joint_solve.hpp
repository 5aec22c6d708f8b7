#pragma once
/// All stations at once: the equations of their common points, and the solution.
#include <utility>
#include <vector>

#include "alignment.hpp"

namespace procam::scan {

/// Poses of all stations, and the rig's error.
struct JointState {
  std::vector<Pose> world_from_rig;
  VecX c;
};

/// Two stations that are compared; the samples are those of the first.
struct ComparedPair {
  int first = 0, second = 0;
  std::vector<StationView::Sample> samples;
};

/// One common point in the world.
struct JointRow {
  int pair = 0;
  double residual = 0, sigma = 0;
  Vec3 point, normal, first_normal, second_normal;
  VecX by_c;
};

struct JointProblem {
  const std::vector<Station>* stations = nullptr;
  const std::vector<StationView>* views = nullptr;
  std::vector<ComparedPair> pairs;
  Eigen::Index modes = 0;  ///< elements of c
  bool has_known_poses = false;
  double min_normal_motion = 0;

  Eigen::Index pose_unknowns() const { return 6 * Eigen::Index(stations->size()); }
  Eigen::Index unknowns() const { return pose_unknowns() + modes; }
};

/// Common points at a state. `with_modes`: also their derivatives by c.
std::vector<JointRow> joint_rows(const JointProblem& problem, const JointState& state, double gate,
                                 bool with_modes);

/// How rows are weighted: 1 / (kernel * sigma)^2 with the kernel of Geman and McClure, at residual = width.
struct RowWeights {
  double scale = 1;   ///< standard deviation of a row over its sigma
  double width = 4;   ///< of the kernel, in scaled sigmas
  double design = 1;  ///< variances are larger by this factor, because rows share errors
  double of(const JointRow& row) const {
    const double sigma = scale * row.sigma, u = row.residual / (width * sigma), kernel = 1 / (1 + u * u);
    return kernel * kernel / (sigma * sigma * design);
  }
};

/// Directions of the stations that the common surfaces do not fix.
struct Unobservable {
  /// By station: unit vectors over [L rotation, translation] about the centre, as columns.
  std::vector<MatX> directions;
  std::vector<Vec3> centres;    ///< of the common points, in the world
  std::vector<double> lengths;  ///< L, their RMS distance from the centre
  /// By station: RMS motion along the normals in the least observable direction, the others fixed.
  std::vector<double> smallest;
  /// The same of all stations moving together, against that of points whose whole motion is seen; and that direction.
  double smallest_together = 1;
  VecX together;
  bool any() const {
    for (const MatX& of_station : directions)
      if (of_station.cols() > 0) return true;
    return false;
  }
};

struct JointEquations {
  MatX information;  ///< of the rows alone
  VecX gradient;
  MatX prior;  ///< information of the known poses and of c
  VecX prior_gradient;
  MatX clustered;  ///< sum over cubes of g g^T
  Unobservable open;
};

/// Where the poses are known, the unobservable directions have no information by the rows.
JointEquations joint_equations(const JointProblem& problem, const JointState& state,
                               const std::vector<JointRow>& rows, const RowWeights& weights);

/// H^-1 (M + P) H^-1; zero for what is fixed.
MatX joint_covariance(const JointProblem& problem, const JointEquations& equations);

/// Mean ratio of the clustered variance to that of independent rows; at least 1.
double design_effect(const JointProblem& problem, const JointEquations& equations);

struct JointSolution {
  JointState state;
  RowWeights weights;
  std::vector<JointRow> rows;
  JointEquations equations;
};

/// From a state that is right to within `gate` along the normals. Throws Error(kNotConverged).
JointSolution solve_jointly(const JointProblem& problem, JointState state, double gate);

/// In words: "position along (1.00 0.00 0.00)", "rotation about the axis (0.00 0.00 1.00) through (0.1 0.2 1.5)".
std::vector<std::string> direction_names(const MatX& directions, const Vec3& centre, double length);

}  // namespace procam::scan
