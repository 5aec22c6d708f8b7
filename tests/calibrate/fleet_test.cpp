/// Several cameras and projectors in one solve: any chain of shared views will do.
#include <gtest/gtest.h>

#include "procam/analyze/light_error.hpp"
#include "procam/calibrate/calibrate.hpp"
#include "support/numeric_fleet.hpp"

namespace procam::calibrate {
namespace {

using test::NumericFleet;

constexpr int kLeft = 0, kRight = 1, kLamp = 2, kBeamer = 3;

/// Both cameras in three views only; the lamp is read by the left one or both, the beamer by the right one
/// or both.
std::vector<test::Cast> loosely_joined() {
  return {{kLeft, kLamp}, {kLeft, kRight, kLamp, kBeamer}, {kRight, kBeamer},
          {kLeft, kLamp}, {kLeft, kRight, kLamp, kBeamer}, {kRight, kBeamer},
          {kLeft, kLamp}, {kLeft, kRight, kBeamer},        {kRight, kBeamer}};
}

Options flat_board() {
  Options options;
  options.board_shape = BoardShape::kFlat;
  return options;
}

/// Estimated minus true by the covariance's names.
std::vector<std::pair<std::string, double>> errors_of(const Rig& rig, const Rig& truth) {
  std::vector<std::pair<std::string, double>> errors;
  const auto add = [&](const std::string& name, const Camera& lens, const Camera& true_lens, const Pose& pose,
                       const Pose& true_pose) {
    const VecX difference = parameters_of(lens) - parameters_of(true_lens);
    const std::vector<std::string> names = parameter_names(lens);
    for (std::size_t i = 0; i < names.size(); ++i)
      errors.emplace_back(name + "." + names[i], difference[Eigen::Index(i)]);
    const Vec6 xi = se3_log(pose * true_pose.inverse());
    for (int i = 0; i < 6; ++i)
      errors.emplace_back(pose_increment_names("rig_from_" + name)[std::size_t(i)], xi[i]);
  };
  for (const RigCamera& t : truth.cameras)
    add(t.name, rig.camera(t.name).camera, t.camera, rig.camera(t.name).rig_from_camera, t.rig_from_camera);
  for (const RigProjector& t : truth.projectors)
    add(t.name, rig.projector(t.name).projector.inverse_camera, t.projector.inverse_camera,
        rig.projector(t.name).rig_from_projector, t.rig_from_projector);
  return errors;
}

TEST(Fleet, IsFoundExactlyFromViewsThatTheFirstCameraNeedNotSee) {
  const NumericFleet fleet = NumericFleet::make(loosely_joined(), 3);
  const CalibrationResult result = calibrate_rig(fleet.correspondences(1), flat_board());
  EXPECT_TRUE(result.rig.quality.passed());
  EXPECT_EQ(result.rig.quality.views_used, 9);
  EXPECT_LT(result.joint_rms_px, 1e-6);
  for (const auto& [name, error] : errors_of(result.rig, fleet.rig))
    EXPECT_LT(std::abs(error), name.find("_from_") == std::string::npos ? 1e-4 : 1e-8) << name;
}

/// 50 parameters in each of six seeds, correlated within a seed: the mean squared score of independent ones
/// would have a standard deviation of 0.08, correlation makes it about twice that, so that one in some two
/// hundred choices of seeds lies outside.
TEST(Fleet, SigmasAreHonestForEveryDevice) {
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const NumericFleet fleet = NumericFleet::make(loosely_joined(), seed, 0.08, 0.05);
    Options options = flat_board();
    options.outlier_sigmas = 0;
    const CalibrationResult result = calibrate_rig(fleet.correspondences(seed + 10), options);
    for (const auto& [name, error] : errors_of(result.rig, fleet.rig)) {
      if (!result.rig.covariance.index_of(name)) continue;
      const double score = error / result.rig.covariance.sigma(name);
      EXPECT_LT(std::abs(score), 6) << name << ", seed " << seed;
      sum += score * score;
      ++count;
    }
    for (const char* name : {"lamp", "beamer"})
      EXPECT_LT(analyze::true_light_error(result.rig, fleet.rig, 2, name).rms_mm,
                4 * analyze::predicted_light_error(result.rig, 2, name).rms_mm);
  }
  EXPECT_EQ(count, 6 * (2 * 10 + 2 * 10 + 3 * 6));
  EXPECT_NEAR(sum / count, 1, 0.5);
}

/// The light itself is exact here, so that all of a projector's error is that of the corners where it was
/// read.
TEST(Fleet, FreesLightFromTheErrorOfTheCornerThatItsOwnCameraFound) {
  const NumericFleet fleet = NumericFleet::make(loosely_joined(), 9, 0.08, 1e-4);
  const Correspondences data = fleet.correspondences(1);
  BundleState truth{{}, {}, fleet.rig_from_board, points_in_board(data.board)};
  for (int d = 0; d < 4; ++d) {
    truth.lenses.push_back(fleet.lens(d));
    truth.device_from_rig.push_back(fleet.rig_from(d).inverse());
  }
  int by_right = 0;
  for (std::size_t v = 0; v < data.views.size(); ++v)
    for (const int projector : {kLamp, kBeamer})
      for (const Measurement& m : measurements_of(data, int(v), projector)) {
        by_right += m.camera() == kRight;
        EXPECT_LT(reprojection_residual(truth, m)->norm(), 0.005);
      }
  EXPECT_GT(by_right, 100);
  const CalibrationResult result = calibrate_rig(data, flat_board());
  EXPECT_GT(result.rms_px[kRight], 0.08);
  EXPECT_LT(result.rms_px[kLamp], 0.005);
  EXPECT_LT(result.rms_px[kBeamer], 0.005);
}

TEST(Fleet, IsHeldOutViewByView) {
  const NumericFleet fleet = NumericFleet::make(loosely_joined(), 4, 0.08, 0.05);
  Options options = flat_board();
  options.holdout = true;
  const CalibrationResult result = calibrate_rig(fleet.correspondences(2), options);
  ASSERT_EQ(result.holdout_px.size(), 4u);
  for (const double px : result.holdout_px) {
    EXPECT_GT(px, 0.04);
    EXPECT_LT(px, 0.5);
  }
}

/// The cameras never see one board together; each reads the beamer, which then tells how they stand.
TEST(Fleet, IsJoinedByAProjectorThatBothCamerasRead) {
  const NumericFleet fleet = NumericFleet::make({{kLeft, kLamp, kBeamer},
                                                 {kLeft, kBeamer},
                                                 {kLeft, kLamp, kBeamer},
                                                 {kLeft, kLamp},
                                                 {kRight, kBeamer},
                                                 {kRight, kBeamer},
                                                 {kRight, kBeamer}},
                                                5);
  const CalibrationResult result = calibrate_rig(fleet.correspondences(1), flat_board());
  for (const auto& [name, error] : errors_of(result.rig, fleet.rig))
    EXPECT_LT(std::abs(error), name.find("_from_") == std::string::npos ? 1e-3 : 1e-7) << name;
}

TEST(Fleet, IsRefusedWhenNoViewJoinsItsDevices) {
  const NumericFleet fleet = NumericFleet::make({{kLeft, kLamp},
                                                 {kLeft, kLamp},
                                                 {kLeft, kLamp},
                                                 {kRight, kBeamer},
                                                 {kRight, kBeamer},
                                                 {kRight, kBeamer}},
                                                6);
  try {
    calibrate_rig(fleet.correspondences(1), flat_board());
    FAIL() << "two rigs were taken for one";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kNotEnoughData);
    const std::string words = error.what();
    EXPECT_NE(words.find("no view joins left and lamp to right and beamer"), std::string::npos) << words;
    EXPECT_NE(words.find("left sees the board while right sees the board"), std::string::npos) << words;
  }
}

TEST(Fleet, NamesTheViewWhosePicturesWereExchanged) {
  std::vector<test::Cast> casts(7, {kLeft, kRight, kLamp, kBeamer});
  const NumericFleet fleet = NumericFleet::make(casts, 7, 0.08, 0.05);
  Correspondences data = fleet.correspondences(1);
  auto& seen = data.views[3].observations;
  std::swap(seen[kLeft], seen[kRight]);
  for (const int projector : {kLamp, kBeamer})
    for (Observation& o : seen[std::size_t(projector)]) o.camera = 1 - o.camera;
  const CalibrationResult result = calibrate_rig(data, flat_board());
  std::string words;
  for (const Diagnostic& d : result.diagnostics.items) words += d.message + "\n";
  EXPECT_NE(words.find("view view_3 rejected for left: its pictures are those of right"), std::string::npos)
      << words;
  EXPECT_TRUE(result.rig.quality.passed());
  EXPECT_FALSE(result.views[3].used);
  for (const char* name : {"lamp", "beamer"})  // four times the rms of 2-D Gaussians: never
    EXPECT_LT(analyze::true_light_error(result.rig, fleet.rig, 2, name).rms_mm,
              4 * analyze::predicted_light_error(result.rig, 2, name).rms_mm);
}

TEST(Fleet, SettlesTheOrderOfASymmetricBoardForEachCamera) {
  NumericFleet fleet =
      NumericFleet::make(std::vector<test::Cast>(6, {kLeft, kRight, kBeamer}), 8, 0.08, 0.05);
  fleet.board = Chessboard{9, 7, 0.03};
  fleet.rig.projectors.erase(fleet.rig.projectors.begin());
  for (test::Cast& cast : fleet.casts) cast = {0, 1, 2};
  Correspondences data = fleet.correspondences(1);
  for (const std::size_t v : {1u, 4u})
    for (std::size_t d : {1u, 2u})
      for (Observation& o : data.views[v].observations[d])
        if (d == 1 || o.camera == 1) o.point = 62 - o.point;
  const CalibrationResult result = calibrate_rig(data, flat_board());
  EXPECT_NE(result.views[1].note.find("order of right's corners turned"), std::string::npos);
  EXPECT_LT(result.joint_rms_px, 0.2);
}

}  // namespace
}  // namespace procam::calibrate
