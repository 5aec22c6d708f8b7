#include <gtest/gtest.h>

#include <cmath>

#include "procam/analyze/landing_error.hpp"
#include "procam/analyze/monte_carlo.hpp"
#include "procam/core/geometry/se3.hpp"
#include "uncertain_rig.hpp"

namespace procam::analyze {
namespace {

/// A pose measured through the rig's own camera: the calibration's errors act twice, and together.
TEST(MeasuredPose, SharesTheCalibrationsErrorsWithTheLight) {
  Rig rig = test::uncertain_rig();
  rig.cameras[0].rig_from_camera = Pose(so3_exp(Vec3(0.02, 0.1, -0.05)), Vec3(0.05, -0.02, 0.01));
  // The camera's focal length goes with the projector's, as it does when both come from one session.
  NamedCovariance& known = rig.covariance;
  const Eigen::Index n = known.matrix.rows();
  known.names.push_back("camera.fx");
  known.matrix.conservativeResize(n + 1, n + 1);
  const VecX with_others = 0.5 * known.matrix.col(0).head(n);
  known.matrix.col(n).head(n) = with_others;
  known.matrix.row(n).head(n) = with_others.transpose();
  known.matrix(n, n) = 4;

  const Pose camera_from_world(so3_exp(Vec3(0.2, -0.5, 0.1)), Vec3(0.1, -0.1, 1.8));
  const LightPath path = light_path(rig.projector(), "world", Pose(),
                                    camera_from_world.inverse() * rig.cameras[0].rig_from_camera.inverse());
  MatX by_lens = MatX::Zero(6, Eigen::Index(parameter_names(rig.cameras[0].camera).size()));
  by_lens.col(0) << 6e-4, -9e-4, 2e-4, 2e-3, -1e-3, 6e-3;  // rotation, translation by fx
  ErrorSources together;
  together.calibration = rig.covariance;
  set_measured_pose(together, rig.cameras[0], 1e-7 * Mat6::Identity(), by_lens);
  const Vec2 point(0.08, -0.05);
  const LandingError closed = *landing_error(path, together, point);
  MonteCarloOptions options;
  options.draws = 40000;
  options.seed = 5;
  const LandingSpread drawn = *monte_carlo_landing(path, together, {point}, options).front();
  // Relative error of a drawn sigma: 1 / sqrt(2 * 40000) = 0.35 %; 6 of these for second order besides.
  for (int axis = 0; axis < 2; ++axis)
    EXPECT_NEAR(std::sqrt(drawn.covariance(axis, axis) / closed.total.covariance(axis, axis)), 1, 0.025);

  // What is lost when the pose's error is taken as one of its own.
  ErrorSources apart = together;
  apart.through_camera.reset();
  const Mat6 to_rig = adjoint(rig.cameras[0].rig_from_camera);
  apart.rig_pose += to_rig * by_lens.col(0) * 4 * by_lens.col(0).transpose() * to_rig.transpose();
  const LandingError wrong = *landing_error(path, apart, point);
  EXPECT_GT(std::abs(wrong.total.rms() / closed.total.rms() - 1), 0.05);
}

/// One error of everything, of known sign: the light moves as the chain that is right instead says.
TEST(MeasuredPose, MovesWithTheCalibrationThatMeasuredIt) {
  Rig rig = test::uncertain_rig();
  RigCamera& camera = rig.cameras[0];
  camera.rig_from_camera = Pose(so3_exp(Vec3(0.02, 0.1, -0.05)), Vec3(0.05, -0.02, 0.01));
  const Pose camera_from_world(so3_exp(Vec3(0.2, -0.5, 0.1)), Vec3(0.1, -0.1, 1.8));
  const auto path_of = [&](const Rig& with, const Pose& seen) {
    return light_path(with.projector(), "world", Pose(),
                      seen.inverse() * with.cameras[0].rig_from_camera.inverse());
  };
  const LightPath path = path_of(rig, camera_from_world);
  MatX by_lens = MatX::Zero(6, Eigen::Index(parameter_names(camera.camera).size()));
  by_lens.col(0) << 6e-4, -9e-4, 2e-4, 2e-3, -1e-3, 6e-3;
  const double projector_fx = 0.3, camera_fx = -0.2;
  Vec6 mount;
  mount << 1e-4, -2e-4, 3e-4, 2e-4, 1e-4, -4e-4;
  VecX wrong(8);
  wrong << projector_fx, camera_fx, mount;
  ErrorSources sources;
  sources.calibration.names = {"projector.fx", "camera.fx"};
  for (const std::string& name : pose_increment_names("rig_from_camera"))
    sources.calibration.names.push_back(name);
  sources.calibration.matrix = wrong * wrong.transpose();
  set_measured_pose(sources, camera, Mat6::Zero(), by_lens);

  Rig right = rig;
  right.projectors[0].projector.inverse_camera.intrinsics.fx += projector_fx;
  right.cameras[0].rig_from_camera = se3_exp(mount) * camera.rig_from_camera;
  const Pose right_camera_from_world = se3_exp(Vec6(by_lens.col(0) * camera_fx)) * camera_from_world;
  const Vec2 point(0.08, -0.05);
  const LandingError closed = *landing_error(path, sources, point);
  const Vec2 moved = *landing_place(path_of(right, right_camera_from_world), closed.pixel) - point;
  EXPECT_LT((closed.total.covariance - moved * moved.transpose()).norm(), 0.02 * moved.squaredNorm());

  // Increments in the camera's frame and in the pose's parent, carried over by what they do.
  const auto carried = [](const Pose& through, const Mat6& covariance) -> Mat6 {
    Mat6 by;
    for (int i = 0; i < 6; ++i)
      by.col(i) = 1e6 * se3_log(through * se3_exp(Vec6(1e-6 * Vec6::Unit(i))) * through.inverse());
    return by * covariance * by.transpose();
  };
  Mat6 covariance = Mat6::Zero();
  covariance.diagonal() << 1e-6, 2e-6, 3e-6, 4e-6, 5e-6, 6e-6;
  set_measured_pose(sources, camera, covariance, by_lens);
  EXPECT_LT((sources.rig_pose - carried(camera.rig_from_camera, covariance)).norm(), 1e-10);
  EXPECT_LT((own_frame_covariance({camera_from_world, covariance}) -
             carried(camera_from_world.inverse(), covariance))
                .norm(),
            1e-10);
}

}  // namespace
}  // namespace procam::analyze
