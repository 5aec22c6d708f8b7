#pragma once
/// Private to calibrate: a device that was moved against the rig while the session was captured, by so little
/// that no view was rejected.
#include <optional>
#include <string>

#include "solve.hpp"

namespace procam::calibrate {

/// A device's pose in the views from `first_after` on against that in the views before.
struct RigMotion {
  int device = 0;
  std::size_t last_before = 0, first_after = 0;  ///< views
  Pose motion;                                   ///< device after from device before
  double significance = 0;                       ///< F of the test below
};

/// Tests every instant between two views that take part, at least two (pose groups of) views on either side.
/// With S, g the views' normal equations and p the rows of the device's pose, a step d of that pose in the
/// views A after the instant adds the parameters d with
///   u = sum_A g_v[p],   V = sum_A S_v[p,p] - (sum_A S_v[p,:]) S^-1 (sum_A S_v[:,p]),   d = -V^-1 u
/// and lowers the cost by u^T V^-1 u, six times the views' own variance ratio when nothing moved (a score
/// test: C. R. Rao, "Large sample tests of statistical hypotheses", 1948). The ratio is measured with the
/// step allowed for, from the gradients r_v of the device's pose that remain in each view, over its
/// expectation under independent noise: of all six directions together, sum r_v^T S_v[p,p]^-1 r_v, or of the
/// step's own, sum (d^T r_v)^2, the larger of the two. So
///   F = (u^T V^-1 u / 6) / ratio
/// holds for views that disagree more than their noise explains, too. Returns the instant of the largest F
/// where that exceeds what chance gives in less than one of a hundred sessions of such views.
std::optional<RigMotion> rig_motion(const Correspondences& data, const Solution& solution);

/// The same as a sentence: what moved, when, by how much, what to do.
std::string description(const RigMotion& motion, const Correspondences& data);

}  // namespace procam::calibrate
