#include "procam/scan/viewer_error.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <random>

#include "procam/core/base/stats.hpp"
#include "procam/core/base/words.hpp"
#include "procam/core/geometry/se3.hpp"
#include "rig_error.hpp"

namespace procam::scan {
namespace {

constexpr int kDrawnRigs = 400;
constexpr double kNearestToEye = 0.05;  // metres

/// Points of a scan with their derivatives by c, in the rig's frame.
struct MovedPoints {
  Points3 points;
  std::vector<MatX> by_c;  ///< 3 rows
};

MovedPoints moved_points(const Scan& scan) {
  MovedPoints out;
  const RigModes& modes = scan.rig_modes;
  for (int row = 0; row < modes.rows && modes.count() > 0; ++row)
    for (int column = 0; column < modes.columns; ++column) {
      const Eigen::Vector2i at = pixel_of_cell(scan.depth, column, row);
      if (at.x() < 0) continue;
      const double z = double(scan.depth.at(at.x(), at.y()));
      const std::optional<Vec3> bearing = scan.camera.camera.unproject(at.cast<double>());
      MatX errors;
      if (!bearing || !rig_modes_at(modes, at.cast<double>(), z, errors)) continue;
      out.points.push_back(scan.camera.rig_from_camera * Vec3(*bearing * (z / bearing->z())));
      out.by_c.push_back(errors.topRows<3>());
    }
  return out;
}

Eigen::Matrix<double, 3, 6> by_motion(const Vec3& point) {
  Eigen::Matrix<double, 3, 6> out;
  out << -hat(point), Mat3::Identity();
  return out;
}

/// The same without the rigid motion of all points that is nearest to each column, by least squares.
void remove_rigid_motion(MovedPoints& moved) {
  if (moved.points.size() < 3) return;
  Mat6 normal = Mat6::Zero();
  MatX right = MatX::Zero(6, moved.by_c.front().cols());
  for (std::size_t i = 0; i < moved.points.size(); ++i) {
    const auto motion = by_motion(moved.points[i]);
    normal += motion.transpose() * motion;
    right += motion.transpose() * moved.by_c[i];
  }
  const MatX common = normal.ldlt().solve(right);
  for (std::size_t i = 0; i < moved.points.size(); ++i) moved.by_c[i] -= by_motion(moved.points[i]) * common;
}

ViewerAngle angles(const MovedPoints& moved, const Vec3& eye) {
  std::vector<Eigen::Matrix<double, 3, Eigen::Dynamic>> turned;
  for (std::size_t i = 0; i < moved.points.size(); ++i) {
    const Vec3 sight = moved.points[i] - eye, v = sight.normalized();
    const double distance = std::max(sight.norm(), kNearestToEye);
    turned.emplace_back((moved.by_c[i] - v * (v.transpose() * moved.by_c[i])) / distance);
  }
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::vector<double> of_rigs;
  for (int rig = 0; rig < kDrawnRigs; ++rig) {
    VecX c(turned.front().cols());
    for (double& element : c) element = normal(random);
    std::vector<double> of_points;
    for (const auto& by_c : turned) of_points.push_back((by_c * c).norm());
    of_rigs.push_back(quantile(std::move(of_points), 0.95));
  }
  return {quantile(of_rigs, 0.5), quantile(of_rigs, 0.95)};
}

void remark_viewer(ViewerError& error) {
  if (!(error.given.of_95 > kViewerPixel)) return;
  const auto pixels = [](double angle) { return px(angle / kViewerPixel, 1); };
  error.diagnostics.warn(
      "viewer_off",
      "content for the viewer is off by more than 1 px of an image of 1280 px across 60 degrees in more than 5 % of the rigs "
      "with this covariance (by " +
          pixels(error.given.of_95) + "), where eye and content are given in the rig; " +
          (error.placed.of_95 > kViewerPixel ? "placed by this scan by " + pixels(error.placed.of_95) +
                                                   "; calibrate the rig with more views"
                                             : "place both by this scan (" + pixels(error.placed.of_95) +
                                                   "), or calibrate the rig with more views"));
}

}  // namespace

ViewerError viewer_error(const Scan& scan, const Vec3& eye_in_rig) {
  require(eye_in_rig.allFinite(), "viewer_error: the eye's position is not finite");
  MovedPoints moved = moved_points(scan);
  ViewerError out;
  out.points = int(moved.points.size());
  if (moved.points.empty()) return out;
  out.given = angles(moved, eye_in_rig);
  remove_rigid_motion(moved);
  out.placed = angles(moved, eye_in_rig);
  remark_viewer(out);
  return out;
}

}  // namespace procam::scan
