/// What is predicted for a driving robot against what a simulated drive does.
#include <gtest/gtest.h>

#include <random>

#include "procam/analyze/landing_error.hpp"
#include "procam/simulate/drive.hpp"
#include "uncertain_rig.hpp"

namespace procam::analyze {
namespace {

/// The robot drives at 0.5 m/s, turns at 30 degrees/s past a wall at an angle, and its poses are 100 ms old
/// when they become light.
struct DrivePastAWall {
  static constexpr double kStamp = 0.2, kDelay = 0.1, kJitter = 0.006, kPosition = 0.008,
                          kRotation = 0.4 * kDegree;
  Rig rig = test::uncertain_rig();
  Vec6 twist = (Vec6() << 0.02, -30 * kDegree, 0.01, 0.1, -0.03, 0.489).finished();
  Vec6 twist_sigma = (Vec6() << 0.01, 0.05, 0.02, 0.03, 0.02, 0.05).finished();
  simulate::Drive drive{test::lopsided_pose(), {simulate::constant_twist(twist, 0.6)}};
  Pose world_from_wall =
      drive.world_from_rig(kStamp) * Pose(so3_exp(Vec3(0.15, -0.7, 0.1)), Vec3(0.1, -0.3, 1.9));
  Vec2 point = *landing_place(path_from(drive.world_from_rig(kStamp)), Vec2(470, 330));

  LightPath path_from(const Pose& world_from_rig) const {
    return light_path(rig.projector(), "world", world_from_wall, world_from_rig);
  }

  struct Landed {
    Vec2 mean = Vec2::Zero();
    Mat2 covariance = Mat2::Zero();
  };
  /// Over as many drives as seeds: the pixel by the pose that the localiser told, the light by where the rig
  /// truly was when it came.
  Landed drive_often(int seeds, bool predicted) const {
    std::mt19937_64 random(99);
    std::normal_distribution<double> normal;
    Points2 offsets;
    Landed landed;
    for (int seed = 0; seed < seeds; ++seed) {
      simulate::Localiser localiser;
      localiser.rate = 5;
      localiser.delay = kDelay;
      localiser.jitter = kJitter;
      localiser.position_sigma = kPosition;
      localiser.rotation_sigma = kRotation;
      localiser.seed = std::uint64_t(seed);
      for (const simulate::LocalisedPose& told : simulate::localise(drive, localiser)) {
        if (std::abs(told.stamp - kStamp) > 1e-6) continue;
        Vec6 believed_twist = twist;
        for (int i = 0; i < 6; ++i) believed_twist[i] += twist_sigma[i] * normal(random);
        const Pose believed =
            predicted ? told.measured * se3_exp(Vec6(kDelay * believed_twist)) : told.measured;
        const Pose projector_from_wall =
            rig.projector().rig_from_projector.inverse() * believed.inverse() * world_from_wall;
        const auto pixel =
            rig.projector().projector.project(projector_from_wall * Vec3(point.x(), point.y(), 0));
        offsets.push_back(*landing_place(path_from(drive.world_from_rig(told.arrival)), *pixel) - point);
        landed.mean += offsets.back() / seeds;
      }
    }
    EXPECT_EQ(int(offsets.size()), seeds);
    for (const Vec2& offset : offsets)
      landed.covariance += (offset - landed.mean) * (offset - landed.mean).transpose() / (seeds - 1);
    return landed;
  }

  LandingError predict(bool predicted) const {
    ErrorSources sources;
    sources.rig_pose = isotropic_pose_covariance(kPosition, kRotation);
    sources.motion.twist = twist;
    sources.motion.twist_sigma = twist_sigma;
    sources.motion.delay = kDelay;
    sources.motion.delay_sigma = kJitter;
    sources.motion.predicted = predicted;
    return *landing_error(path_from(drive.world_from_rig(predicted ? kStamp + kDelay : kStamp)), sources,
                          point);
  }
};

/// 2000 drives: a sigma's standard error is 1.6 %, so 10 % is six of them; the mean's is below 1 % of the
/// bias. The seeds are fixed.
TEST(DriveError, OfALatePoseIsWhatTheDriveShows) {
  const DrivePastAWall world;
  const auto driven = world.drive_often(2000, false);
  const LandingError predicted = world.predict(false);
  const Vec2 bias = predicted.total.bias;
  EXPECT_GT(bias.norm(), 0.08);
  EXPECT_LT((driven.mean - bias).norm(), 0.02 * bias.norm());
  for (int axis = 0; axis < 2; ++axis)
    EXPECT_NEAR(std::sqrt(driven.covariance(axis, axis) / predicted.total.covariance(axis, axis)), 1, 0.1);
}

TEST(DriveError, OfAPredictedPoseIsWhatTheDriveShows) {
  const DrivePastAWall world;
  const auto driven = world.drive_often(2000, true);
  const LandingError predicted = world.predict(true);
  EXPECT_EQ(predicted.total.bias.norm(), 0);
  EXPECT_LT(driven.mean.norm(), 0.1 * predicted.total.rms());
  for (int axis = 0; axis < 2; ++axis)
    EXPECT_NEAR(std::sqrt(driven.covariance(axis, axis) / predicted.total.covariance(axis, axis)), 1, 0.1);
}

}  // namespace
}  // namespace procam::analyze
