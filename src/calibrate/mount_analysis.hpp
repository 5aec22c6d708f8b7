#pragma once
/// Private to calibrate: what the equations of calibrate_mount tell beside the solution.
#include <Eigen/SparseCholesky>
#include <array>
#include <optional>

#include "mount_model.hpp"

namespace procam::calibrate::mount {

/// J^T J and its factors.
struct Equations {
  explicit Equations(Linear linear);
  Linear linear;
  Eigen::SparseMatrix<double> normal;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor;

  /// W with W^T W = right^T normal^-1 right: half of a solution. normal = P^T L D L^T P, W = D^(-1/2) L^-1 P right.
  MatX half_solved(MatX right) const;
};

/// sqrt(sum r^2 / redundancy) of each group: by what its standard deviations are off. 1 for an empty group.
std::array<double, kGroups> variance_factors(const Equations& equations);

/// Variance at low frequency over that of white noise, of the localiser's residuals; at least 1.
double correlation_of(const Linear& linear, const Model& model);

/// What the drive and the stated measurements tell about the last mount's directions (with the axes of a head: 8,
/// else 6), the time offset, and where the base stands in the world.
struct MountInformation {
  MatX data, posterior;  ///< information about the mount, all else eliminated
  MatX covariance;       ///< of the directions, after the stated measurements
  double offset_sigma = 0;
  double scale_sigma = 0;  ///< of Model::scale, where it is estimated
  MatX sensor_covariance;  ///< of Model::sensor; empty without planes
  /// Of the right increments, by marker; of a plane 3 x 3; empty where no sighting is left.
  std::vector<MatX> marker_covariance;
  MatX world_covariance;       ///< of the right increment of world_from_base; empty without it
  MatX directions_with_world;  ///< covariance of the directions (rows) with it (columns)
};
MountInformation mount_information(const Equations& equations, bool with_offset);

/// Directions with a standard deviation above `max_sigma`.
std::vector<bool> unobservable_directions(const MatX& information, double max_sigma);

/// Of each direction by the drive alone; infinite where it tells nothing.
std::vector<double> direction_sigmas(const MatX& information);

/// By what the lengths of the localiser differ from those of the sightings, to first order; chi2 with one degree of
/// freedom. `problem` made the equations.
struct FoundScale {
  double chi2 = 0, increment = 0;
};
FoundScale find_scale(const Model& model, const MountProblem& problem, const Equations& equations);

/// The most significant change, if there is one. `problem` made the equations.
struct FoundEvent {
  MountEvent::Kind kind = MountEvent::Kind::kRigBumped;
  double time = 0;  ///< camera's clock for a bump, localiser's for a jump
  double chi2 = 0, other_chi2 = 0;
  Vec6 increment = Vec6::Zero();  ///< of the mount's directions; right increment of the localiser's frame
};
std::optional<FoundEvent> find_event(const Model& model, const MountProblem& problem,
                                     const Equations& equations);

}  // namespace procam::calibrate::mount
