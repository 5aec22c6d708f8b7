/// Rigs that do not belong to the light: how far the standard deviations grow, what fails, and what is refused.
#include <gtest/gtest.h>

#include "procam/scan/scan.hpp"
#include "procam/scan/scan_error.hpp"
#include "support/expect_error.hpp"
#include "true_room.hpp"

namespace procam::scan::test {
namespace {

constexpr double kLightSigma = 0.05;  // projector pixels

SeenRoom look_at_alcove(const Rig& truth) {
  std::mt19937 random(21);
  return look(truth, alcove(), Pose(), kLightSigma, random);
}

Rig rotated(const Rig& truth, const Vec3& angle) {
  Rig rig = truth;
  Pose& pose = rig.projectors[0].rig_from_projector;
  pose = pose * Pose(so3_exp(angle), Vec3::Zero());
  return rig;
}

Rig without_covariance(Rig rig) {
  rig.covariance = {};
  return rig;
}

/// The light as a camera would have it whose images are changed.
LightMap flipped(const LightMap& light, bool flip_x, bool flip_y) {
  LightMap out = light;
  const int width = light.pixel.width(), height = light.pixel.height();
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 2; ++c) {
        const int i = flip_x ? width - 1 - x : x, j = flip_y ? height - 1 - y : y;
        out.pixel.at(x, y, c) = light.pixel.at(i, j, c);
        out.sigma.at(x, y, c) = light.sigma.at(i, j, c);
      }
  return out;
}

TEST(Consistency, OfTheTrueRigAddsNothing) {
  const Rig truth = without_covariance(true_rig());
  const Scan scan = measure_depth(look_at_alcove(truth).light, truth);
  EXPECT_EQ(scan.diagnostics.find("rig_inconsistent"), nullptr);
  EXPECT_TRUE(scan.misfit_sigma.empty());
  EXPECT_EQ(scan.consistency_px_of_rig, 0);
}

/// Half a pixel: a warning, and points that are about as far off as their standard deviations. By the noise alone 1 % are
/// inside three of them.
TEST(Consistency, EnlargesTheStandardDeviationsWithTheMisfit) {
  const Rig truth = without_covariance(true_rig());
  const SeenRoom seen = look_at_alcove(truth);
  for (const Vec3& angle : {Vec3(0.0012, 0, 0), Vec3(0, -0.004, 0), Vec3(0, 0, 0.004)}) {
    const Scan scan = measure_depth(seen.light, rotated(truth, angle));
    ASSERT_NE(scan.diagnostics.find("rig_inconsistent"), nullptr) << angle.transpose();
    EXPECT_FALSE(scan.diagnostics.failed()) << scan.consistency_px;
    ASSERT_FALSE(scan.misfit_sigma.empty());
    const ScanError error = compare(scan, seen.truth.depth);
    EXPECT_GT(error.inside_3_sigma, 0.9) << angle.transpose();
    EXPECT_LT(error.rms, 3 * error.expected_rms) << angle.transpose();
  }
}

TEST(Consistency, FailsWhereTheRigWasBumped) {
  const Rig truth = true_rig();
  const SeenRoom seen = look_at_alcove(truth);
  for (const Vec3& angle : {Vec3(0.006, 0, 0), Vec3(0, 0.01, 0)}) {
    const Scan scan = measure_depth(seen.light, rotated(truth, angle));
    ASSERT_TRUE(scan.diagnostics.failed()) << scan.consistency_px;
    const Diagnostic* failure = scan.diagnostics.find("rig_inconsistent");
    ASSERT_NE(failure, nullptr);
    for (const char* cause : {"bumped since its calibration", "another session", "moved during the frames"})
      EXPECT_NE(failure->message.find(cause), std::string::npos) << failure->message;
    const ScanError error = compare(scan, seen.truth.depth);
    EXPECT_LT(error.rms, 3 * error.expected_rms) << angle.transpose();
  }
}

/// The same bump is no failure where the rig states a covariance that explains it.
TEST(Consistency, AllowsForTheCovarianceOfTheRig) {
  Rig truth = true_rig();
  const SeenRoom seen = look_at_alcove(truth);
  const Rig sure = rotated(truth, Vec3(0.006, 0, 0));
  EXPECT_TRUE(measure_depth(seen.light, sure).diagnostics.failed());
  Rig unsure = sure;
  unsure.covariance.matrix(8, 8) += 0.004 * 0.004;
  const Scan scan = measure_depth(seen.light, unsure);
  EXPECT_FALSE(scan.diagnostics.failed());
  EXPECT_GT(scan.consistency_px_of_rig, 0.5 * scan.consistency_px);
  EXPECT_LT(scan.consistency_px_of_rig, 2 * scan.consistency_px);
}

/// Over rigs drawn from the covariance, whose error is made larger than the noise: the mean square of the misfit is predicted.
/// With some three effective degrees of freedom a draw, 20 draws have a standard error of 18 %; three of them.
TEST(Consistency, OfTheRigIsPredictedByItsCovariance) {
  Rig truth = true_rig();
  truth.covariance.matrix *= 20 * 20;
  const SeenRoom seen = look_at_alcove(truth);
  std::mt19937 random(23);
  double squares = 0, predicted = 0;
  for (int draw = 0; draw < 20; ++draw) {
    const Scan scan = measure_depth(seen.light, calibrated_rig(truth, random));
    EXPECT_FALSE(scan.diagnostics.failed()) << draw;
    squares += scan.consistency_px * scan.consistency_px;
    predicted += scan.consistency_px_of_rig * scan.consistency_px_of_rig + kLightSigma * kLightSigma;
  }
  EXPECT_NEAR(squares / predicted, 1, 0.55);
}

TEST(Consistency, NamesImagesThatWereMirroredOrRotated) {
  const Rig truth = true_rig();
  const SeenRoom seen = look_at_alcove(truth);
  const auto refusal = [&](bool flip_x, bool flip_y) {
    return procam::test::error_of([&] { measure_depth(flipped(seen.light, flip_x, flip_y), truth); });
  };
  EXPECT_NE(refusal(true, false).why().find("mirrored left to right"), std::string::npos)
      << refusal(true, false).what();
  EXPECT_NE(refusal(false, true).why().find("mirrored top to bottom"), std::string::npos)
      << refusal(false, true).what();
  EXPECT_NE(refusal(true, true).why().find("rotated by 180 degrees"), std::string::npos)
      << refusal(true, true).what();
}

TEST(Consistency, RefusesTheRigOfAnotherSession) {
  const Rig truth = true_rig();
  const SeenRoom seen = look_at_alcove(truth);
  const Error error =
      procam::test::error_of([&] { measure_depth(seen.light, rotated(truth, Vec3(-0.06, 0.04, 0.02))); });
  EXPECT_EQ(error.kind(), ErrorKind::kNotEnoughData);
  EXPECT_EQ(error.why().find("mirrored"), std::string::npos) << error.what();
  EXPECT_NE(error.next().find("a rig of another session"), std::string::npos) << error.what();
}

/// Never "0 mm" for a scan that is off everywhere.
TEST(ScanError, HasTheErrorsOfOutliersWhereMostAre) {
  const Rig truth = true_rig();
  const SeenRoom seen = look_at_alcove(truth);
  const Scan scan = measure_depth(seen.light, truth);
  ImageF nearer = seen.truth.depth;
  for (int y = 0; y < nearer.height(); ++y)
    for (int x = 0; x < nearer.width(); ++x) nearer.at(x, y) *= x < 12 ? 0.999f : 0.7f;
  TrueView view = seen.truth;
  view.depth = nearer;
  for (const ScanError& error : {compare(scan, nearer), compare(point_cloud(scan), {view})}) {
    EXPECT_GT(error.outliers, 0.9);
    EXPECT_GT(error.median, 0.1);
    EXPECT_GT(error.rms, 0.1);
    EXPECT_GT(error.expected_rms, 0);
  }
}

}  // namespace
}  // namespace procam::scan::test
