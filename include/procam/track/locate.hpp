#pragma once
/// Where the camera is, from the markers that it sees, and from there where the projector is.
///
///   const LocateResult seen = locate(detect::detect_marker_edges(image, codes, {camera}), camera, map);
///   const Chain chain = projector_chain(rig, rig.projector(), rig.camera(), seen);
///   chain.total.target_from_source;   // projector_from_world with its covariance
///
/// detect says where the image shows the borders of the cells; the pose is fitted here, to those edges
/// themselves and through the lens:
///   minimise  sum_i (n_i . (pixel_i - project(camera_from_world * world_from_marker * exp(zeta_m) * x_i)) -
///                    s_m)^2 / var_i  +  |zeta_m / sigma_map|^2  +  (s_m / sigma_s)^2
/// over the pose (left increment), the markers' own misplacements zeta_m (right increment, in the marker's
/// frame) and what moves all edges of a marker towards white, s_m (ink, gamma). x_i is the point of the
/// edge's line that projects closest to pixel_i, n_i the normal of the line's image there: exact for edges
/// that the lens bends. Gauss-Newton over SE(3); zeta and s are eliminated marker by marker.
///
/// One marker, or several in one plane, seen from afar has two poses that look alike (planar_pose.hpp). Both
/// are refined, and the odds of the second follow from their chi-squares.
#include <optional>
#include <string>
#include <vector>

#include "procam/core/base/export.hpp"
#include "procam/core/board/marker.hpp"
#include "procam/core/geometry/frame_tree.hpp"
#include "procam/core/rig/rig.hpp"

namespace procam::track {

struct LocateOptions {
  /// A marker whose corners lie further than this from where the others put it (and three sigmas of the map
  /// and of the image) was moved or measured wrong: it is rejected and named.
  double outlier_px = 1;
  /// Odds of the second pose from which no pose is given.
  double largest_odds = 0.05;
};

/// One marker of the map in the image.
struct LocatedMarker {
  int id = 0;
  bool used = true;
  double edge_rms_px = 0;  ///< of its edges from the fit
  double error_px = 0;     ///< rms distance of its corners from where the fit puts them
  std::string reason;      ///< why it was rejected; empty when used
};

struct LocateResult {
  Pose camera_from_world;
  /// Of the left increment: image noise and the map's sigmas, scaled up when the residuals exceed them. The
  /// lens is taken as exact here.
  Mat6 covariance = Mat6::Zero();
  /// What the lens adds: d increment / d camera parameters, 6 rows, columns in the order of
  /// parameter_names(camera).
  MatX jacobian_lens;
  std::optional<Pose> other;             ///< the second pose that fits, if there is one
  Mat6 other_covariance = Mat6::Zero();  ///< its, as `covariance`
  double other_chi2 = 0;                 ///< its chi-square above that of the first, scaled as the covariance
  double other_odds =
      0;  ///< that it is the true one, 0 .. 1/2: exp(-other_chi2 / 2) / (1 + exp(-other_chi2 / 2))
  double chi2_per_dof = 0;  ///< about 1 when noise and map are as stated
  std::vector<LocatedMarker> markers;
  Diagnostics diagnostics;
};

/// Remarks: "marker_left_out" names a moved marker, "second_pose" gives odds above 1/1000, "map_disagrees"
/// says that the residuals are above twice what image and map promise; above eight times it is a failure: a
/// rotated, cropped or zoomed image, or another rig. "marker_coarse" says that neither edges nor
/// pixels of a marker could be fitted and the detector's corners are used.
///
/// Throws Error kNotEnoughData when no marker of the map is seen, kDegenerate when the markers contradict
/// each other without a majority or when the second pose cannot be excluded, kNotConverged; and
/// std::invalid_argument when the image's size is not the camera's or the map's sizes are not positive.
PROCAM_EXPORT LocateResult locate(const MarkerDetections& detections, const Camera& camera,
                                  const MarkerMap& map, const LocateOptions& options = {});

/// projector_from_world = projector_from_camera * camera_from_world.
struct Chain {
  std::vector<FrameTree::Link> links;  ///< in the order of multiplication, each with its own covariance
  FrameTree::Link total;
};

/// The covariance of the total counts what the rig file says of the lens and of both devices' places once,
/// with its correlations: the links' own covariances overlap where the lens takes part in both.
PROCAM_EXPORT Chain projector_chain(const Rig& rig, const RigProjector& projector, const RigCamera& camera,
                                    const LocateResult& seen);

}  // namespace procam::track
