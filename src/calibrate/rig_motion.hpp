#pragma once
/// Private to calibrate: a device that was moved against the rig, or whose lens was zoomed, refocused or shifted, while the
/// session was captured, by so little that no view was rejected.
#include <string>
#include <vector>

#include "procam/core/geometry/covariance.hpp"
#include "solve.hpp"

namespace procam::calibrate {

/// A device in the views from `first_after` on against the views before.
struct RigMotion {
  int device = 0;
  std::size_t last_before = 0, first_after = 0;  ///< views
  Pose motion;                                   ///< device after from device before
  /// (g, x, y) of its interior orientation as in costs/image_change.hpp, after against before; zero where the device moved.
  Vec3 image_change = Vec3::Zero();
  /// After minus before, of these parameters of the bundle ("projector.fx", "projector_from_rig.rx").
  std::vector<std::string> names;
  VecX step;

  bool of_lens() const { return image_change.x() != 0 || image_change.y() != 0 || image_change.z() != 0; }
};

/// Tests every instant between two views that take part, at least two (pose groups of) views on either side. What may change
/// at it is a device's pose, six directions, or its image: the focal lengths by a common share and the principal point,
/// three directions, of which the first has to dominate. With S, g the views' normal equations and D the directions, a step d
/// in the views A after the instant adds the parameters d with
///   u = sum_A D^T g_v,   V = sum_A D^T S_v D - (sum_A D^T S_v) S^-1 (sum_A D^T S_v)^T,   d = -V^-1 u
/// and lowers the cost by u^T V^-1 u, k times the views' own variance ratio when nothing changed (a score
/// test: C. R. Rao, "Large sample tests of statistical hypotheses", 1948; k directions). The ratio is measured with the
/// step allowed for, from the gradients r_v along D that remain in each view, over its
/// expectation under independent noise: of all directions together, sum r_v^T (D^T S_v D)^-1 r_v, or of the
/// step's own, sum (d^T r_v)^2, the larger of the two. So
///   F = (u^T V^-1 u / k) / ratio
/// holds for views that disagree more than their noise explains, too. What exceeds the F that chance gives in less than one of
/// a hundred sessions of such views, the most probable first, and after it those that the views do not separate from it.
std::vector<RigMotion> rig_motions(const Correspondences& data, const Solution& solution);

/// Adds step step^T / 4, its mean over the motions: the solution lies between the two states of a device, half a step from
/// either, and each of the motions may be the true one. Nothing where there are none.
void add_motions(const std::vector<RigMotion>& motions, NamedCovariance& covariance);

/// The motions as a sentence: what changed, when, by how much, what to do. At least one.
std::string description(const std::vector<RigMotion>& motions, const Correspondences& data);

/// Does the focal length of (g, x, y) displace the image's border more than the principal point does? A principal point alone
/// acts as a turn of the device.
bool is_zoom(const Vec3& change, ImageSize image);

/// "focal length +1.00 %, principal point by (0.5, -0.1) px": of (g, x, y).
std::string image_change_in_words(const Vec3& change);

}  // namespace procam::calibrate
