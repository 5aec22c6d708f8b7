#pragma once
/// The bodies of planar_pose.hpp. NOLINTBEGIN(misc-definitions-in-headers)
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "procam/core/base/cholesky.hpp"
#include "procam/core/base/closed_form.hpp"
#include "procam/core/base/error.hpp"
#include "procam/core/geometry/homography_fit.hpp"
#include "procam/core/geometry/planar_pose.hpp"
#include "procam/core/geometry/se3.hpp"

namespace procam {

namespace detail {

/// The two rotations that agree with the homography's value p and Jacobian J at the plane's origin (Collins &
/// Bartoli 2014, 4.2): with R_v turning the z axis into the view direction (p, 1), the plane's axes as seen
/// in that frame have the top rows A / gamma, A = ([I | -p] R_v)_{2x2}^-1 J, gamma its largest singular
/// value, and a third row +-b.
inline std::array<Mat3, 2> ippe_rotations(const Vec2& p, const Mat2& jacobian) {
  const Mat3 view = rotation_between(Vec3::UnitZ(), Vec3(p.x(), p.y(), 1.0)).toRotationMatrix();
  Mat23 project;
  project << Mat2::Identity(), -p;
  const Mat2 a = (project * view).leftCols<2>().inverse() * jacobian;
  const Mat2 top = a / singular_values(a)[0];
  const Mat2 rest = Mat2::Identity() - top.transpose() * top;  // b b^T
  Vec2 b(std::sqrt(std::max(0.0, rest(0, 0))), std::sqrt(std::max(0.0, rest(1, 1))));
  if (rest(0, 1) < 0.0) b.y() = -b.y();
  std::array<Mat3, 2> rotations;
  for (int k = 0; k < 2; ++k) {
    const Vec2 third = k == 0 ? b : Vec2(-b);
    const Vec3 x(top(0, 0), top(1, 0), third.x()), y(top(0, 1), top(1, 1), third.y());
    Mat3 axes;
    axes << x, y, x.cross(y);
    rotations[k] = view * axes;
  }
  return rotations;
}

/// Given the rotation the projection equations are linear in the translation.
inline Vec3 translation_for(const Mat3& rotation, const Points2& plane_points, const Points2& image_points) {
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (std::size_t i = 0; i < plane_points.size(); ++i) {
    const Vec3 q = rotation.leftCols<2>() * plane_points[i];
    Mat23 m;
    m << 1.0, 0.0, -image_points[i].x(), 0.0, 1.0, -image_points[i].y();
    normal += m.transpose() * m;
    right -= m.transpose() * (m * q);
  }
  return normal.inverse() * right;
}

struct PoseEquations {
  Mat6 normal = Mat6::Zero();
  Vec6 gradient = Vec6::Zero();
  double cost = 0.0;
};

/// nullopt when a point is not in front of the camera.
inline std::optional<PoseEquations> pose_equations(const Pose& camera_from_plane, const Points2& plane_points,
                                                   const Points2& image_points) {
  PoseEquations equations;
  for (std::size_t i = 0; i < plane_points.size(); ++i) {
    const Vec3 p = camera_from_plane * Vec3(plane_points[i].x(), plane_points[i].y(), 0.0);
    if (!(p.z() > 0.0)) return std::nullopt;
    const Vec2 residual = p.head<2>() / p.z() - image_points[i];
    Mat23 by_point;
    by_point << 1.0, 0.0, -p.x() / p.z(), 0.0, 1.0, -p.y() / p.z();
    by_point /= p.z();
    Eigen::Matrix<double, 2, 6> jacobian;
    jacobian << -by_point * hat(p), by_point;
    equations.normal += jacobian.transpose().lazyProduct(jacobian);
    equations.gradient += jacobian.transpose().lazyProduct(residual);
    equations.cost += residual.squaredNorm();
  }
  return equations;
}

/// Levenberg-Marquardt over the left increment; nullopt when the start has points behind the camera.
inline std::optional<PlanarPoseSolution> refine_planar_pose(const Pose& start, const Points2& plane_points,
                                                            const Points2& image_points,
                                                            const std::optional<double>& sigma) {
  PlanarPoseSolution solution;
  solution.camera_from_plane = start;
  std::optional<PoseEquations> equations = pose_equations(start, plane_points, image_points);
  if (!equations) return std::nullopt;
  double damping = 0.0;
  constexpr int kIterations = 50;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Mat6 damped = equations->normal;
    damped.diagonal() *= 1.0 + damping;
    const Vec6 step = -Cholesky(damped).solve(equations->gradient);
    const Pose next = (se3_exp(step) * solution.camera_from_plane).normalized();
    const auto trial = pose_equations(next, plane_points, image_points);
    if (trial && trial->cost <= equations->cost) {
      const double drop = equations->cost - trial->cost;
      solution.camera_from_plane = next;
      equations = trial;
      if (damping == 0.0 && drop <= 1e-14 * trial->cost) break;
      damping = damping < 1e-4 ? 0.0 : 0.1 * damping;
    } else {
      if (step.norm() < 1e-14 || damping > 1e12) break;
      damping = damping == 0.0 ? 1e-3 : 10.0 * damping;
    }
  }
  const double count = double(plane_points.size());
  solution.rmse = std::sqrt(equations->cost / count);
  const double variance = sigma ? *sigma * *sigma : equations->cost / (2.0 * count - 6.0);
  solution.covariance = variance * Cholesky(equations->normal).inverse();
  return solution;
}

}  // namespace detail

PROCAM_CORE_INLINE PlanarPose planar_pose(const Points2& plane_points, const Points2& image_points,
                                          const std::optional<double>& sigma) {
  const Homography image_from_plane = fit_homography(plane_points, image_points).destination_from_source;
  Vec2 centre = Vec2::Zero();
  for (const Vec2& p : plane_points) centre += p / double(plane_points.size());
  Points2 centred;
  for (const Vec2& p : plane_points) centred.push_back(p - centre);

  PlanarPose pose;
  for (const Mat3& rotation :
       detail::ippe_rotations(image_from_plane.apply_unchecked(centre), image_from_plane.jacobian(centre))) {
    const Pose start(rotation, detail::translation_for(rotation, centred, image_points));
    auto solution = detail::refine_planar_pose(start, centred, image_points, sigma);
    if (!solution) continue;
    // Back from the centroid: the left increment, and so its covariance, stays as it is.
    solution->camera_from_plane = solution->camera_from_plane *
                                  Pose(Eigen::Quaterniond::Identity(), Vec3(-centre.x(), -centre.y(), 0.0));
    pose.solutions.push_back(*solution);
  }
  if (pose.solutions.empty())
    throw Error(ErrorKind::kNotConverged,
                "pose of a plane from " + std::to_string(plane_points.size()) + " points",
                "no pose puts all points in front of the camera", "check the pairs for outliers");
  if (pose.solutions.size() == 2) {
    if (pose.solutions[1].rmse < pose.solutions[0].rmse) std::swap(pose.solutions[0], pose.solutions[1]);
    // Frontal views have one minimum, found twice.
    const Vec6 between =
        se3_log(pose.solutions[0].camera_from_plane * pose.solutions[1].camera_from_plane.inverse());
    if (between.head<3>().norm() < 1e-6) pose.solutions.pop_back();
  }
  return pose;
}

}  // namespace procam
// NOLINTEND(misc-definitions-in-headers)
