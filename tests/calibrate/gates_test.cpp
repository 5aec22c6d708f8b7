#include "procam/calibrate/gates.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "procam/calibrate/calibrate.hpp"
#include "rig_checks.hpp"
#include "support/numeric_world.hpp"

namespace procam::calibrate {
namespace {

Rig good_rig() {
  const test::NumericWorld world;
  Rig rig;
  rig.cameras.push_back({"camera", world.camera, Pose()});
  rig.projectors.push_back({"projector", world.projector, world.projector_from_camera.inverse()});
  rig.quality.rms_px = {{"camera", 0.1}, {"projector", 0.12}};
  return rig;
}

/// The names of the gates that failed.
std::string failed(const Rig& rig) {
  std::string names;
  for (const Gate& gate : check_rig(rig))
    if (!gate.passed) names += "[" + gate.name + "]";
  return names;
}

TEST(Gates, PassAShiftedProjectorAsItIs) {
  EXPECT_EQ(failed(good_rig()), "");
}

TEST(Gates, EachFiresForItsReasonAlone) {
  Rig rig = good_rig();
  rig.projectors[0].projector.inverse_camera.intrinsics.cy = 1358;
  EXPECT_EQ(failed(rig), "[projector lens shift]");

  rig = good_rig();
  rig.projectors[0].projector.inverse_camera.intrinsics.fy *= 1.1;
  EXPECT_EQ(failed(rig), "[projector aspect]");

  rig = good_rig();
  rig.cameras[0].camera.intrinsics.cx += 300;
  EXPECT_EQ(failed(rig), "[camera principal point]");

  rig = good_rig();
  rig.cameras[0].camera.intrinsics.fx = rig.cameras[0].camera.intrinsics.fy = 40000;
  EXPECT_EQ(failed(rig), "[camera field of view]");

  rig = good_rig();
  rig.cameras[0].camera.distortion = BrownConrady{{-0.9, 0.0, 0.0, 0.0, 0.0}};  // folds inside the image
  EXPECT_EQ(failed(rig), "[camera distortion monotone]");

  rig = good_rig();
  rig.projectors[0].projector.inverse_camera.distortion = BrownConrady{{-0.05, 0.03, 0.0, -0.021, 0.0}};
  EXPECT_EQ(failed(rig), "[projector tangential distortion]");

  rig = good_rig();
  rig.quality.rms_px["projector"] = 0.86;
  EXPECT_EQ(failed(rig), "[projector RMS]");

  rig = good_rig();
  rig.quality.holdout_px["projector"] = 0.5;
  EXPECT_EQ(failed(rig), "[projector held-out error]");

  rig = good_rig();
  rig.covariance.names = {"projector.fx"};
  rig.covariance.matrix = MatX::Constant(1, 1, 100.0 * 100.0);
  EXPECT_EQ(failed(rig), "[projector focal length known]");
}

TEST(Gates, PointsThatNoLensFitsAreNamed) {
  const auto advice = [](double rms_px) {
    Rig rig = good_rig();
    rig.quality.rms_px["projector"] = rms_px;
    for (const Gate& gate : check_rig(rig))
      if (gate.name == "projector RMS") return gate.detail;
    return std::string();
  };
  EXPECT_NE(advice(83).find("numbered as the board's"), std::string::npos) << advice(83);
  EXPECT_EQ(advice(0.86).find("numbered as the board's"), std::string::npos) << advice(0.86);
  EXPECT_NE(advice(0.86).find("a bent or moved board"), std::string::npos) << advice(0.86);
}

/// Few views predict another one badly, and their sigmas are as large: that is no wrong model. The same
/// figures without sigmas, or with small ones, fail.
TEST(Gates, HeldOutErrorMayBeAsLargeAsTheSigmasExplain) {
  Rig rig = good_rig();
  rig.quality.holdout_px["projector"] = 0.5;
  rig.quality.expected_holdout_px["projector"] = 0.42;  // 1.2 sigmas
  EXPECT_EQ(failed(rig), "");
  rig.quality.expected_holdout_px["projector"] = 0.33;
  EXPECT_EQ(failed(rig), "[projector held-out error]");
}

/// A rig from a file keeps the failures that only its calibration could see; checks that the numbers decide
/// are made again.
TEST(Gates, OfAStoredRigKeepWhatOnlyItsCalibrationSaw) {
  Rig rig = good_rig();
  rig.quality.gates = {{"camera RMS", false, "of an older limit"},
                       {"predicted error", false, "of another wall"},
                       {"views agree", true, "all"}};
  std::string names;
  for (const Gate& gate : check_stored_rig(rig)) names += gate.passed ? "" : "[" + gate.name + "]";
  EXPECT_EQ(names, "");
  rig.quality.gates.push_back({"captures", false, "1 failure in the captures"});
  for (const Gate& gate : check_stored_rig(rig)) names += gate.passed ? "" : "[" + gate.name + "]";
  EXPECT_EQ(names, "[captures]");
}

/// Ten views seen by the camera, four or five of them by the projector: the figures of the whole rig hide that it is
/// calibrated by few views.
TEST(Gates, OfViewsReadNameTheDeviceThatReadsFewerThanHalf) {
  const Correspondences all = test::NumericWorld::make(10, 31, 0.05, 0.05).correspondences(8);
  for (const int read : {4, 5}) {
    Correspondences data = all;
    for (int v = read; v < 10; ++v) data.views[std::size_t(v)].observations[1].clear();
    const CalibrationResult result = calibrate_rig(data);
    const auto& gates = result.rig.quality.gates;
    const auto gate =
        std::find_if(gates.begin(), gates.end(), [](const Gate& g) { return g.name == "views read"; });
    ASSERT_NE(gate, gates.end());
    EXPECT_EQ(gate->passed, read == 5);
    const std::string counts = "camera 10 of 10, projector " + std::to_string(read) + " of 10";
    EXPECT_EQ(gate->detail, read == 5
                                ? counts
                                : counts +
                                      ": fewer than half of the views hold points of projector; the views' "
                                      "remarks give the cause, capture them again");
  }
}

/// Images with an empty border of 300 px: the lens folds there, 906 px from the principal point, and nothing was
/// ever seen there. Its points reach 740 px. The verdict survives the rig file, which holds no points; a
/// fold where points lie fails, and so does any fold of a projector, all of whose frame is lit.
TEST(Gates, OfDistortionLookWhereTheCameraSawPoints) {
  test::NumericWorld world;
  world.camera_sigma_px = world.projector_sigma_px = 0.05;
  world.camera.distortion = BrownConrady{{-0.3, 0.0, 0.0007, -0.0011, 0.0}};
  world.place_boards(12, 5);
  world.camera.size.width += 600, world.camera.size.height += 600;
  world.camera.intrinsics.cx += 300, world.camera.intrinsics.cy += 300;
  const CalibrationResult result = calibrate_rig(world.correspondences(6));
  ASSERT_FALSE(result.rig.camera().camera.unproject(Vec2(0, 0)));
  for (const Gate& gate : result.rig.quality.gates)
    EXPECT_TRUE(gate.passed) << gate.name << ": " << gate.detail;
  for (const Gate& gate : check_stored_rig(result.rig))
    EXPECT_TRUE(gate.passed) << gate.name << ": " << gate.detail;

  const auto failed_with = [](const Rig& rig, double reach) {
    std::string names;
    for (const Gate& gate : check_rig(rig, {}, {{"camera", reach}, {"projector", reach}}))
      if (!gate.passed) names += "[" + gate.name + "]";
    return names;
  };
  EXPECT_EQ(failed_with(result.rig, 800), "");
  EXPECT_EQ(failed_with(result.rig, 1000), "[camera distortion monotone]");
  Rig folded = good_rig();
  folded.projectors[0].projector.inverse_camera.distortion = BrownConrady{{-2.0, 0.0, 0.0, 0.0, 0.0}};
  EXPECT_EQ(failed_with(folded, 400), "[projector distortion monotone]");
}

TEST(Gates, SayWhatToDo) {
  Rig rig = good_rig();
  rig.projectors[0].projector.inverse_camera.intrinsics.cy = 1358;
  for (const Gate& gate : check_rig(rig)) {
    if (gate.passed) continue;
    EXPECT_NE(gate.detail.find("add views"), std::string::npos) << gate.detail;
  }
}

}  // namespace
}  // namespace procam::calibrate
