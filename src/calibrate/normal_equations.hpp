#pragma once
/// Private to calibrate: the normal equations at a solution, a view at a time, with what it has of its own (its board's
/// pose and what else differs from view to view, own_of_view()) eliminated.
#include <string>
#include <utility>
#include <vector>

#include "procam/calibrate/bundle.hpp"

namespace procam::calibrate {

/// Everything that views share, as one vector: free lens parameters and pose increment by device, then the
/// board's points and the sheet's curvature when they are free.
struct CommonParameters {
  CommonParameters(const Correspondences& data, const UsedMask& used, const BundleState& state,
                   const BundleOptions& options);

  int size() const { return int(names.size()); }
  BundleState moved(const BundleState& state, const VecX& step) const;

  std::vector<std::string> names;  ///< "camera.fx", "projector_from_rig.rx", "board.17.z", "sheet.c_xx"
  std::vector<std::vector<int>> free_of_lens;  ///< by device: positions in parameters_of(lens)
  std::vector<int> lens_at, pose_at;           ///< by device: first row; -1 when held
  std::vector<int> point_at;                   ///< by board point: first row; -1 when held
  int sheet_at = -1;                           ///< first row; -1 when held
  int devices_size = 0;                        ///< rows before the board's points
};

/// One view's share: with H = [A, B; B^T, P] and gradient [a; p] over (common, own), own as own_of_view() has it,
///   S_v = A - B P^-1 B^T,   g_v = a - B P^-1 p
struct ViewEquations {
  bool used = false;
  MatX information;     ///< S_v
  VecX gradient;        ///< g_v
  VecX diagonal;        ///< of A
  MatX own_by_common;   ///< P^-1 B^T: the own moves by minus this times the common step
  MatX own_covariance;  ///< P^-1

  Mat6 pose_covariance() const { return own_covariance.topLeftCorner<6, 6>(); }
};

struct NormalEquations {
  std::vector<ViewEquations> views;
  MatX information;  ///< sum of S_v and the prior of the board's points
  VecX diagonal;     ///< of the same before the views' own were eliminated
};

/// The same with the board held where it has hundreds of points: free, they would cost minutes where other unknowns are many as
/// well, and what is smooth over a picture or a sheet depends little on them.
BundleOptions with_few_unknowns(const Correspondences& data, BundleOptions options);

/// What is known beforehand of a lens or of a board's point, as a whitened residual and its derivatives by the common
/// parameters that it depends on.
struct PriorRow {
  std::vector<std::pair<int, double>> by_common;
  double residual = 0;
};
std::vector<PriorRow> prior_rows(const Correspondences& data, const BundleState& solution,
                                 const BundleOptions& options, const CommonParameters& common);

/// Of the views of each pose group together (BundleOptions::pose_groups), `information`, `gradient` and
/// `used` alone; in the order of the groups' numbers.
std::vector<ViewEquations> by_pose_group(const NormalEquations& equations, const BundleOptions& options);

/// Weighed as the solver weighs them, robust loss included.
/// Throws Error(kDegenerate) naming a view whose pose its measurements do not determine.
NormalEquations normal_equations(const Correspondences& data, const UsedMask& used,
                                 const BundleState& solution, const BundleOptions& options,
                                 const CommonParameters& common);

}  // namespace procam::calibrate
