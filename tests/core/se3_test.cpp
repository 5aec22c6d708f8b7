#include "procam/core/geometry/se3.hpp"

#include <gtest/gtest.h>

#include "procam/core/base/dual.hpp"
#include "support/lopsided.hpp"

namespace procam {
namespace {

const Vec3 kAxis = Vec3(0.48, -0.6, 0.64).normalized();

/// Angles on both sides of every switch between series and closed form, and up to pi.
const double kAngles[] = {0,      1e-300,  1e-12, 1e-7, 1e-6,       9.9e-5,     1.01e-4,
                          9.9e-3, 1.01e-2, 0.3,   1.9,  kPi - 1e-4, kPi - 1e-9, kPi};

Vec6 increment(const Vec3& rotation, const Vec3& translation) {
  Vec6 xi;
  xi << rotation, translation;
  return xi;
}

/// R by Rodrigues' formula, independent of quaternions.
Mat3 rodrigues(const Vec3& axis, double angle) {
  const Mat3 k = hat(axis);
  return Mat3::Identity() + std::sin(angle) * k + 2 * std::pow(std::sin(angle / 2), 2) * k * k;
}

TEST(Hat, IsTheCrossProduct) {
  const Vec3 v(1.3, -0.2, 0.7), w(0.4, 2.1, -0.9);
  EXPECT_LT((hat(v) * w - v.cross(w)).norm(), 1e-15);
}

TEST(So3, ExpIsRodriguesAtEveryAngle) {
  for (const double angle : kAngles) {
    const Eigen::Quaterniond q = so3_exp(Vec3(angle * kAxis));
    EXPECT_LT((q.toRotationMatrix() - rodrigues(kAxis, angle)).norm(), 2e-15) << angle;
    EXPECT_NEAR(q.norm(), 1, 1e-15) << angle;
  }
}

TEST(So3, LogUndoesExpFromTinyAnglesToPi) {
  for (const double angle : kAngles) {
    const Vec3 w = angle * kAxis;
    const Vec3 back = so3_log(so3_exp(w));
    EXPECT_LT((back - w).norm(), 1e-15 + 2e-15 * angle) << angle;
  }
}

TEST(So3, LogTakesTheShortWayForEitherSignOfTheQuaternion) {
  const Eigen::Quaterniond q = so3_exp(Vec3(2.9 * kAxis));
  const Eigen::Quaterniond minus(-q.w(), -q.x(), -q.y(), -q.z());
  EXPECT_LT((so3_log(minus) - so3_log(q)).norm(), 1e-14);
  // 4 rad about the axis is 2 pi - 4 about its opposite.
  EXPECT_LT((so3_log(so3_exp(Vec3(4 * kAxis))) - (4 - 2 * kPi) * kAxis).norm(), 1e-14);
}

TEST(So3, LeftJacobianIsTheDerivativeOfExp) {
  for (const double angle : {0.0, 1e-6, 9.9e-3, 1.01e-2, 0.3, 1.9, 3.1}) {
    const Vec3 w = angle * kAxis;
    const double h = 1e-5;
    Mat3 numeric;
    for (int i = 0; i < 3; ++i) {
      const Vec3 d = h * Vec3::Unit(i);
      numeric.col(i) = (so3_log(Eigen::Quaterniond(so3_exp(Vec3(w + d)) * so3_exp(w).conjugate())) -
                        so3_log(Eigen::Quaterniond(so3_exp(Vec3(w - d)) * so3_exp(w).conjugate()))) /
                       (2 * h);
    }
    EXPECT_LT((so3_left_jacobian(w) - numeric).norm(), 1e-9) << angle;
  }
}

TEST(So3, LeftJacobianHasNoStepWhereTheSeriesEnds) {
  // Of its exact form, sum of hat(w)^n / (n+1)!, at the switch of 0.01 rad: algebra accuracy on both sides.
  for (const double angle : {0.00999, 0.01001, 0.1, 0.5}) {
    const Mat3 w_hat = hat(Vec3(angle * kAxis));
    Mat3 sum = Mat3::Identity(), term = Mat3::Identity();
    for (int n = 1; n < 20; ++n) {
      term = Mat3(term * w_hat) / (n + 1);
      sum += term;
    }
    EXPECT_LT((so3_left_jacobian(Vec3(angle * kAxis)) - sum).norm(), 1e-15) << angle;
  }
}

TEST(Se3, ExpIsTheMatrixExponential) {
  const Vec6 xi = increment(Vec3(0.9, -1.1, 0.7), Vec3(0.3, 1.4, -2.2));
  Mat4 generator = Mat4::Zero();
  generator.topLeftCorner<3, 3>() = hat(Vec3(xi.head<3>()));
  generator.topRightCorner<3, 1>() = xi.tail<3>();
  Mat4 sum = Mat4::Identity(), term = Mat4::Identity();
  for (int n = 1; n < 40; ++n) {
    term = Mat4(term * generator) / n;
    sum += term;
  }
  EXPECT_LT((se3_exp(xi).matrix() - sum).norm(), 1e-13);
}

TEST(Se3, LogUndoesExpFromTinyAnglesToPi) {
  for (const double angle : kAngles) {
    const Vec6 xi = increment(angle * kAxis, Vec3(0.31, -1.7, 0.45));
    EXPECT_LT((se3_log(se3_exp(xi)) - xi).norm(), 1e-14) << angle;
  }
}

TEST(Se3, ExpUndoesLogOfRandomPoses) {
  std::mt19937_64 random(11);
  for (int i = 0; i < 200; ++i) {
    const Pose pose = test::random_pose(random);
    EXPECT_LT((se3_exp(se3_log(pose)).matrix() - pose.matrix()).norm(), 1e-13);
  }
}

TEST(Se3, AdjointCarriesAnIncrementAcrossThePose) {
  const Pose pose = test::lopsided_pose();
  const Vec6 xi = increment(Vec3(0.2, -0.5, 0.4), Vec3(1.1, 0.3, -0.6));
  const Vec6 carried = adjoint(pose) * xi;
  EXPECT_LT(((pose * se3_exp(xi)).matrix() - (se3_exp(carried) * pose).matrix()).norm(), 1e-14);
}

TEST(Se3, AdjointOfAChainIsTheProduct) {
  const Pose a = test::lopsided_pose(), b = test::other_lopsided_pose();
  EXPECT_LT((adjoint(Pose(a * b)) - adjoint(a) * adjoint(b)).norm(), 1e-14);
  EXPECT_LT((adjoint(a.inverse()) * adjoint(a) - Mat6::Identity()).norm(), 1e-14);
}

/// Derivatives must survive where closed forms divide by zero: at the identity and at tiny angles.
TEST(Se3, ExpAndLogCarryDerivativesEverywhere) {
  using D = Dual<6>;
  for (const double angle : {0.0, 1e-9, 1e-4, 9.9e-3, 1.01e-2, 1.3, 3.1}) {
    const Vec6 xi = increment(angle * kAxis, Vec3(0.31, -1.7, 0.45));
    Eigen::Matrix<D, 6, 1> variables;
    for (int i = 0; i < 6; ++i) variables[i] = D(xi[i], i);
    const Eigen::Matrix<D, 6, 1> back = se3_log(se3_exp(variables));
    for (int i = 0; i < 6; ++i) {
      EXPECT_NEAR(back[i].a, xi[i], 1e-14) << angle;
      EXPECT_LT((back[i].v - Vec6::Unit(i)).norm(), 1e-11) << angle << " row " << i;
    }
  }
}

}  // namespace
}  // namespace procam
