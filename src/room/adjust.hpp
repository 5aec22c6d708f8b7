#pragma once
/// Bundle adjustment over lenses, poses and one inverse depth a point.
///
/// A point is d / w in its anchor's frame, d = (a, b, 1) the ray of the anchor's pixel, w its inverse depth. In the
/// frame of device s, times w (a projection does not change by it),
///
///   U = R_a d + w t_a (rig),    Y_s = R_s^T (U - w t_s),    rig_from_device = (R, t), increments on the left.
///
/// Each point's depth is eliminated by its Schur complement, so that the system has the devices' parameters alone
/// (Triggs, McLauchlan, Hartley, Fitzgibbon, "Bundle adjustment - a modern synthesis", 2000, sections 6.1 and 9).
/// Levenberg-Marquardt; outliers by iteratively reweighted least squares with the loss of Geman and McClure.
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "procam/core/geometry/pose.hpp"
#include "procam/core/lens/camera.hpp"
#include "procam/room/points.hpp"

namespace procam::room {

/// Devices are numbered: poses by camera positions, then projectors; lenses by cameras, then projectors.
struct RoomState {
  std::vector<Camera> lenses;
  std::vector<Pose> rig_from_device;
  std::vector<char> solved;           ///< by pose: the device has a place
  std::vector<double> inverse_depth;  ///< by point, of the anchor; not finite: unknown
};

/// sum weight * parameter = value, one standard deviation sigma; parameters of one lens.
struct LensKnowledge {
  int lens = 0;
  std::vector<std::pair<int, double>> terms;  ///< index in parameters_of(), weight
  double value = 0, sigma = 1;
};

struct AdjustOptions {
  std::vector<std::vector<char>> free;  ///< by lens and parameter
  std::vector<LensKnowledge> known;
  int max_iterations = 40;
  double robust_sigmas = 4;  ///< scale of the loss in units of the points' scatter; 0: least squares
  int threads = 0;
};

/// What a point's readings leave, all in standard deviations.
struct PointFit {
  double square = 0;  ///< sum of squares
  int freedom = 0;    ///< rows less one, 0: not in use
};

/// The parameters of the system: offsets of each lens' free parameters and each pose. The first pose that has a
/// place is fixed and must be the identity; the distance of the farthest one from it is fixed as well.
struct Layout {
  std::vector<std::vector<int>> lens;  ///< by lens and parameter; -1: fixed
  std::vector<int> pose;               ///< of the first of six; -1: fixed
  int size = 0;
  int scale_pose = -1;  ///< its distance from the first position is fixed
};

struct Normal {
  MatX information;  ///< of the parameters, depths eliminated, with the priors
  VecX gradient;
  MatX prior;  ///< the priors' part, and the scale's
  double cost = 0;
};

struct AnchoredPoint;

class Adjustment {
 public:
  Adjustment(const RoomPoints& points, const AdjustOptions& options);

  /// Points that take part: their anchor and a reading's devices have a place. Empty: all.
  std::vector<char> used;

  /// Improves the state. Returns the robust scale: the scatter of the readings over their stated sigmas.
  double solve(RoomState& state) const;

  PointFit fit(const RoomState& state, int point) const;
  /// Brings a point's depth to its minimum, the devices as they are; false: none in front of the devices.
  bool refine_depth(RoomState& state, int point) const;
  /// The depth from scratch: where its rays meet.
  bool start_depth(RoomState& state, int point) const;

  Layout layout(const RoomState& state) const;
  Normal normal(const RoomState& state, const Layout& layout, double loss_square) const;
  /// Covariance of the parameters by Layout: by parameter the larger of the inverse of the information times `scale`^2 and
  /// the cluster-robust one. The errors of a light map are alike in a region of its image: the readings there are one cluster,
  /// also those of different points. (K.-Y. Liang and S. Zeger, "Longitudinal data analysis using generalized linear models",
  /// Biometrika 73, 1986.)
  MatX covariance(const RoomState& state, const Layout& layout, double scale) const;
  double scatter(const RoomState& state) const;
  /// Sum of squares of the points in use and of the priors.
  double cost(const RoomState& state) const { return cost(state, layout(state), 0); }
  /// d log(depth) / d parameters of a point, the light as it is; and the standard deviation of log(depth) by the
  /// light's noise for readings as certain as stated. nullopt: not in use.
  struct DepthGradient {
    VecX by_parameters;
    double noise = 0;
  };
  /// `only_anchor`: by the anchor's camera and projector alone, as a scan of the rig measures it.
  std::optional<DepthGradient> depth_gradient(const RoomState& state, const Layout& layout, int point,
                                              bool only_anchor) const;
  /// What the lenses' priors cost, squares of standard deviations.
  double prior(const RoomState& state) const { return prior_cost(state, layout(state), nullptr); }
  RoomState moved(const RoomState& state, const Layout& layout, const VecX& step) const;

 private:
  struct Rows;
  /// Regions of a light map, by the camera's image.
  static constexpr int kRegionColumns = 10, kRegionRows = 8;
  int region(const LightReading& reading) const;
  /// All readings of a point together: sums of squares of the residuals, of the derivatives by the depth, and of both.
  struct DepthRows {
    double square = 0, curvature = 0, slope = 0;
    int count = 0;  ///< readings
    void add(const Vec2& by_depth, const Vec2& residual) {
      square += residual.squaredNorm();
      curvature += by_depth.squaredNorm();
      slope += by_depth.dot(residual);
      ++count;
    }
  };
  /// nullopt: a device cannot see the point, or it has no depth.
  std::optional<DepthRows> depth_rows(const RoomState& state, int point) const;
  bool linearise(const RoomState& state, const Layout& layout, int point, Rows& rows,
                 bool only_anchor = false) const;
  /// The point by its anchor's ray and its depth; nullopt where one of them is missing.
  std::optional<AnchoredPoint> anchored_point(const RoomState& state, const Layout* layout, int point) const;
  /// Every depth in use towards its minimum, the devices as they are: two Gauss-Newton steps.
  void settle_depths(RoomState& state) const;
  double cost(const RoomState& state, const Layout& layout, double loss_square) const;
  double prior_cost(const RoomState& state, const Layout& layout, Normal* normal) const;
  bool active(const RoomState& state, int point, int reading) const;
  int camera_lens(int position) const { return points_.positions[std::size_t(position)].camera; }
  int projector_lens(int projector) const { return int(points_.cameras.size()) + projector; }
  int projector_pose(int projector) const { return int(points_.positions.size()) + projector; }

  const RoomPoints& points_;
  AdjustOptions options_;
};

/// Pixel and its derivatives by the point and by all parameters of the lens.
struct ProjectedPoint {
  Vec2 pixel;
  Mat23 by_point;
  Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, 16> by_lens;
};
std::optional<ProjectedPoint> project_point(const Camera& lens, const Vec3& point);

}  // namespace procam::room
