#pragma once
/// What moved, from the shifts of the cells: the projector in the rig, one surface, or the rig in the room.
///
///   shift_i = J_i x + s_i delay + noise_i
///
/// x are left increments [rotation, translation] in the rig's frame. Each explanation has a prior: what rig and surfaces are
/// known to (`projector_covariance`, the delay), and a bump of one thing. The noise of a cell is that of its measurement and a
/// systematic part (`cell_sigma`: lens model, flatness, content that looks blurred), which no averaging reduces; it is
/// enlarged when the cells disagree more. Cells that contradict the others lose their weight (Cauchy's function, then a
/// limit).
///
/// Test: the shifts are projected onto all that movements can do, after the known uncertainties (a score test, C. R. Rao,
/// 1948). Without a movement the squared length is chi-square; its degrees of freedom are the directions that the cells
/// determine to less than a bump. A movement shows in all cells, and the outline of a person who stands still in a few: the
/// test is repeated without each neighbourhood of 3 x 3 cells (`of_others`).
///
/// A surface has a second prior of 0.5 m and 0.3 radians, 1000 times rarer than a bump: its light is on something before it (a
/// person, a board). Of both priors the explanation is the one that costs less.
///
/// Explanations are ordered by their evidence, the probability of the shifts over all movements that the prior allows. One
/// is ruled out only if its best fit is worse than another's by more than chance allows (plausible()). On one plane a rig
/// that moves and a surface that moves do the same to the light; so do a projector that moves along the line to the camera
/// and a surface that comes nearer. A movement of a surface along itself moves no light in the rig: nothing here sees it.
/// The estimate keeps the prior's uncertainty there, and `error` does not include it.
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/geometry/covariance.hpp"
#include "procam/watch/cell_shifts.hpp"

namespace procam::watch {

enum class MovedThing { kNothing, kProjector, kSurface, kRig };

/// One explanation of the shifts.
struct Explanation {
  MovedThing thing = MovedThing::kNothing;
  std::string name;  ///< the projector's, the surface's, "rig", or "nothing"
  /// Left increment in the rig's frame: true rig_from_thing = exp(moved) * rig_from_thing. Of the rig in the room: that of
  /// all surfaces, which move together before it; rig_from_world = exp(moved) * rig_from_world.
  Vec6 moved = Vec6::Zero();
  Mat6 covariance = Mat6::Zero();
  double shift = 0;  ///< of the thing's centre, metres
  double cost =
      0;  ///< of the best fit: squared residuals and movement in units of their sigmas; differences count
  double log_evidence = 0;  ///< differences count
  double probability = 0;   ///< among the explanations, all as probable before
  double error = 0;         ///< of the light across its surface, RMS over the measured cells, metres
  double error_sigma = 0;   ///< its standard deviation, RMS of the predicted one, metres
  /// Of a surface: it is nearer by 0.1 m or more, and so may be something that stands before it.
  bool is_before = false;
};

struct MovementOptions {
  double bump_rotation = 0.0175,
         bump_translation = 0.02;  ///< one standard deviation an axis, radians and metres
  Mat6 projector_covariance =
      Mat6::Zero();  ///< of rig_from_projector relative to the camera, left increments
  /// What the models of lenses and photometry leave, as a movement of the projector: it is the same in all cells.
  double model_rotation = 3e-5, model_translation = 1e-4;
  double surface_rotation = 5e-4, surface_translation = 5e-4;  ///< to which each surface is known
  double delay_sigma = 0.004;                                  ///< of the moment that the camera saw, seconds
  double cell_sigma = 0.13;  ///< systematic error of a cell, working pixels, an axis
  double rejection = 12;     ///< chi-square of a cell (two degrees of freedom) above which it is rejected
};

struct MovementEstimate {
  int cells = 0;               ///< that take part
  int rejected = 0;            ///< measured cells that contradict the others
  double chi2 = 0;             ///< of the test
  int degrees_of_freedom = 0;  ///< 0: the cells determine nothing
  double probability = 1;      ///< of a chi2 as large without a movement
  double of_others =
      1;  ///< the largest probability without a neighbourhood of 3 x 3 cells; 1 where `probability` is 0.01 or more
  double scatter = 1;                     ///< residuals over their expected size, at least 1
  double delay = 0;                       ///< estimate, seconds: the camera saw later than assumed
  std::vector<Explanation> explanations;  ///< the most probable first; "nothing" is one of them
  std::vector<double> weights;            ///< of each given shift, 0: rejected or not measured

  /// Explanations whose cost is at most so much above the smallest, "nothing" not among them, the best fit first: evidence
  /// prefers, of small movements, the one that the cells determine worst. 16: chance
  /// rules out the true one in 1 of 1000 estimates (three more parameters, chi-square).
  PROCAM_EXPORT std::vector<const Explanation*> plausible(double more = 16) const;
};

/// Shifts of cells of this geometry. Without enough of them (four cells) the estimate has no degrees of freedom.
PROCAM_EXPORT MovementEstimate estimate_movement(const LightGeometry& geometry, const std::string& projector,
                                                 const std::vector<CellShift>& shifts,
                                                 const MovementOptions& options = {});

/// What one image tells of the rig's place in the room, if nothing else has moved: for rig_from_world = exp(x) rig_from_world,
/// with a left increment x in the rig's frame,
///
///   log p(shifts | x) = score . x - x^T information x / 2 + const.
///
/// Light shows a plane's distance and its two tilts, nothing along it. So the information has rank 3 for one plane, 5 for two
/// that meet and 6 for three. What projector, surfaces and delay are known to (MovementOptions) is marginalised; the bump's
/// prior is not in it.
struct RigInformation {
  Mat6 information = Mat6::Zero();
  Vec6 score = Vec6::Zero();
  int cells = 0;  ///< that take part; 0: none is known
};
PROCAM_EXPORT RigInformation rig_information(const LightGeometry& geometry,
                                             const std::vector<CellShift>& shifts,
                                             const MovementOptions& options = {});

/// 1 for each measured cell that agrees with the others on some movement, else 0: the first step of estimate_movement().
PROCAM_EXPORT std::vector<double> agreeing_cells(const LightGeometry& geometry,
                                                 const std::vector<CellShift>& shifts,
                                                 const MovementOptions& options = {});

/// Covariance of the projector's place relative to a camera of the rig, as left increments of rig_from_projector, from the
/// rig's covariance. Zero for a rig without one.
PROCAM_EXPORT Mat6 projector_covariance(const Rig& rig, const std::string& projector,
                                        const std::string& camera);

}  // namespace procam::watch
