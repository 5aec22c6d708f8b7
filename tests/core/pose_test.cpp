#include "procam/core/geometry/pose.hpp"

#include <gtest/gtest.h>

#include "support/lopsided.hpp"

namespace procam {
namespace {

const Pose kB_from_a = test::lopsided_pose();
const Pose kC_from_b = test::other_lopsided_pose();
const Vec3 kPoint(0.7, -0.4, 2.2);

TEST(Pose, MovesAPointAsItsMatrixDoes) {
  const Vec4 by_matrix = kB_from_a.matrix() * kPoint.homogeneous();
  EXPECT_LT((kB_from_a * kPoint - by_matrix.head<3>()).norm(), 1e-14);
  EXPECT_EQ(by_matrix[3], 1);
  EXPECT_LT((kB_from_a.matrix34() * kPoint.homogeneous() - by_matrix.head<3>()).norm(), 1e-14);
}

TEST(Pose, ChainsFromRightToLeft) {
  EXPECT_LT((kC_from_b * kB_from_a * kPoint - kC_from_b * (kB_from_a * kPoint)).norm(), 1e-14);
  EXPECT_LT(((kC_from_b * kB_from_a).matrix() - kC_from_b.matrix() * kB_from_a.matrix()).norm(), 1e-14);
}

TEST(Pose, InverseUndoesIt) {
  EXPECT_LT((kB_from_a.inverse() * (kB_from_a * kPoint) - kPoint).norm(), 1e-14);
  EXPECT_LT(((kB_from_a * kB_from_a.inverse()).matrix() - Mat4::Identity()).norm(), 1e-14);
  EXPECT_LT((kB_from_a.inverse().matrix() - kB_from_a.matrix().inverse()).norm(), 1e-14);
}

TEST(Pose, TranslationDoesNotActOnDirections) {
  EXPECT_LT((kB_from_a.rotate(kPoint) - (kB_from_a * kPoint - kB_from_a * Vec3(Vec3::Zero()))).norm(), 1e-14);
}

TEST(Pose, ComesFromARotationMatrix) {
  const Pose again(kB_from_a.rotation_matrix(), kB_from_a.translation);
  EXPECT_LT((again.matrix() - kB_from_a.matrix()).norm(), 1e-14);
  EXPECT_NEAR(again.rotation.norm(), 1, 1e-15);
}

TEST(Pose, NormalizedRemovesDriftOfTheQuaternion) {
  Pose drifted = kB_from_a;
  drifted.rotation.coeffs() *= 1.001;
  EXPECT_LT((drifted.normalized().matrix() - kB_from_a.matrix()).norm(), 1e-14);
}

TEST(Pose, KnowsWhetherItIsFinite) {
  EXPECT_TRUE(kB_from_a.is_finite());
  Pose bad = kB_from_a;
  bad.rotation.y() = std::nan("");
  EXPECT_FALSE(bad.is_finite());
  bad = kB_from_a;
  bad.translation.z() = INFINITY;
  EXPECT_FALSE(bad.is_finite());
}

TEST(Pose, CastsToFloatAndBack) {
  EXPECT_LT((kB_from_a.cast<float>().cast<double>().matrix() - kB_from_a.matrix()).norm(), 1e-6);
}

}  // namespace
}  // namespace procam
