#pragma once
/// Known lenses against the light: what it says of them when they are as unknown as those of a data sheet.
#include <cmath>
#include <optional>
#include <vector>

#include "start.hpp"

namespace procam::room {

/// Points that take part, as Adjustment has them, and their scatter.
struct PointsInUse {
  std::vector<char> used;
  double scatter = 0;  ///< by the known lenses
};

/// The rig with lenses free that were taken as known.
struct FreedRig {
  RoomState state;
  Layout layout;
  MatX covariance, information;  ///< by the layout; the information with the priors
};

/// The best focal length of the chosen lenses and the rest of the rig that belongs to it. Where light barely tells a
/// focal length, the cost is a narrow curved valley that bundle adjustment follows in small steps; along the focal
/// length it is a smooth line.
RoomState along_focal_length(const RoomPoints& points, const LensPlan& plan, const std::vector<char>& chosen,
                             const RoomState& given, const std::vector<char>& used, int threads);

/// `plan` is widened() for the chosen lenses. `given` is the solution by the known lenses, where open_lenses() stays
/// and free_lenses() begins.
FreedRig open_lenses(const RoomPoints& points, const LensPlan& plan, const RoomState& given,
                     const PointsInUse& in_use, int threads);
FreedRig free_lenses(const RoomPoints& points, const LensPlan& plan, const std::vector<char>& chosen,
                     const RoomState& given, const PointsInUse& in_use, int threads);

/// One parameter of a known lens that the light contradicts.
struct LensDisagreement {
  int lens = 0, parameter = 0;
  double off = 0, sigma = 0;  ///< the light's estimate less the known value; of the difference
  /// Smooth errors of the light feign three deviations now and then, not five.
  bool is_certain() const { return std::abs(off) > 5 * sigma; }
};

/// The parameter of the chosen lenses that is off by most standard deviations, those of `plan` and of the light
/// together, where it is off by more than three of them and by more than 0.5 % of the focal length, width or corner.
std::optional<LensDisagreement> disagreement(const LensPlan& plan, const FreedRig& freed,
                                             const std::vector<char>& chosen);

/// The parameter of the chosen lenses that the solution moved farthest from its stated value, in stated standard deviations:
/// where it is more than a right one moves. `sigma` is the stated one.
std::optional<LensDisagreement> departure(const LensPlan& plan, const RoomState& state,
                                          const std::vector<char>& chosen);

/// Mean square error of the solution by the known lenses: the covariance of the freed rig and the square of the
/// distance between both. It covers the truth wherever the light puts it.
MatX kept_covariance(const FreedRig& freed, const RoomState& given);

/// The same where the light's own estimate is not to be trusted (one plane, one position): the covariance of the given
/// solution and the lens' prior carried through it (parameters that are considered, not estimated; S. F. Schmidt 1966).
///   C = [ C_p + S P S^T, S P ; P S^T, P ],   S = -H_pp^-1 H_pl.
MatX considered_covariance(const LensPlan& wide, const FreedRig& freed, const Layout& given_layout,
                           const MatX& given_covariance);

}  // namespace procam::room
