/// Captures that others published: Gray code on a printed 7x9 board through the tools, and two cameras' views
/// of a 9x6 board through the library.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "e2e/tool_runner.hpp"
#include "procam/calibrate/calibrate.hpp"
#include "procam/detect/chessboard.hpp"
#include "procam/io/board_file.hpp"
#include "procam/io/image/images.hpp"
#include "procam/session/join.hpp"
#include "procam/session/reader.hpp"
#include "support/test_data.hpp"
#include "uncertainty.hpp"

namespace procam::test {
namespace {

TEST(RealCaptures, CalibrateToTheKnownRig) {
  PROCAM_REQUIRE_TEST_DATA("graycode/capture_0");
  const ScratchFolder folder;
  const ToolRun run = run_tool(
      "calibrate-projector",
      "--captures " + (test_data() / "graycode").string() +
          " --pattern gray --projector-size 1024x768 --board chessboard:7x9:75mm --holdout --json -o " +
          (folder / "rig.json").string() + " --report " + (folder / "report.html").string());
  // Five boards, all of one tilt about the horizontal axis: sound numbers, but some 3.5 mm at 2 m.
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json summary = run.json();
  EXPECT_EQ(summary["gates"]["failed"], 0);
  EXPECT_GT(summary["wall"]["rms_mm"], 2);
  EXPECT_LT(summary["wall"]["rms_mm"], 5);
  EXPECT_LT(summary["wall"]["by_camera"]["rms_mm"], 1);
  EXPECT_LT(summary["next_view"]["rms_mm"], 0.7 * summary["wall"]["rms_mm"].get<double>());
  // Camera and projector stand by 0.12 px otherwise from view to view: without that, the projector's RMS is 0.036 px.
  EXPECT_NEAR(summary["image_changes"]["camera"]["shift_rms_px"], 0.12, 0.05);
  EXPECT_LT(summary["rms_px"]["projector"], 0.02);
  EXPECT_EQ(summary["views_used"], 5);
  EXPECT_EQ(summary["points_found"]["camera"], 5 * 63);
  EXPECT_EQ(summary["points_found"]["projector"], 5 * 63);
  const double fx = summary["projector"]["fx"], cy = summary["projector"]["cy"];
  EXPECT_GT(fx, 1865);
  EXPECT_LT(fx, 1900);
  EXPECT_GT(cy, 830);  // below the 768-row picture: real lens shift
  EXPECT_LT(cy, 890);
  // Every point counts, the curled corners of the sheet included: the board's shape explains them.
  EXPECT_TRUE(summary["board"]["free_shape"]);
  EXPECT_LE(summary["rms_all_px"]["camera"], 0.13);
  EXPECT_LE(summary["rms_all_px"]["projector"], 0.11);
  EXPECT_LE(summary["rms_all_px"]["joint"], 0.13);
  EXPECT_LE(summary["holdout_all_px"]["projector"], 0.17);
  EXPECT_TRUE(std::filesystem::exists(folder / "rig.json"));
  EXPECT_NE(slurp(folder / "report.html").find("</html>"), std::string::npos);
}

/// On real data: the jackknife in closed form against whole refits without each pose, the board's shape and the changes of
/// the camera's image among the unknowns. Measured: ratios of 0.89 to 1.10, but for the camera's p1 (1.25) and for fy of
/// both (0.79 and 0.82): without the fifth of these poses it moves farther than the closed form predicts.
TEST(RealCaptures, JackknifeAgreesWithWholeRefits) {
  PROCAM_REQUIRE_TEST_DATA("graycode/capture_0");
  io::SessionInfo stated;
  stated.pattern = "gray";
  stated.projector_size = ImageSize{1024, 768};
  stated.board = io::read_board("chessboard:7x9:75mm");
  calibrate::Options options;
  // Averaged terms are no refit's: the solution that the closed form differentiates is the one without them.
  options.camera.held = options.projector.held = {"skew", "k3"};
  const calibrate::CalibrationResult result = calibrate::calibrate_rig(
      session::read(session::open(test_data() / "graycode", {stated, {}})).correspondences, options);
  const auto& [data, used, state, bundle_options] = result.solved;
  std::map<std::string, double> variance;
  for (std::size_t v = 0; v < data.views.size(); ++v) {
    calibrate::UsedMask without = used;
    for (auto& of_device : without[v]) std::fill(of_device.begin(), of_device.end(), char(0));
    const calibrate::BundleState refit = calibrate::bundle_adjust(data, without, state, bundle_options).state;
    for (std::size_t d = 0; d < data.devices.size(); ++d) {
      const VecX moved = parameters_of(refit.lenses[d]) - parameters_of(state.lenses[d]);
      const auto names = parameter_names(refit.lenses[d]);
      for (std::size_t i = 0; i < names.size(); ++i)
        variance[data.devices[d].name + "." + names[i]] +=
            0.8 * moved[Eigen::Index(i)] * moved[Eigen::Index(i)];
    }
  }
  const NamedCovariance closed =
      calibrate::bundle_uncertainty(data, used, state, bundle_options).jackknife.plain;
  for (const auto& [name, of_refits] : variance) {
    if (closed.index_of(name)) {
      const double ratio = closed.sigma(name) / std::sqrt(of_refits);
      EXPECT_GT(ratio, name.size() > 3 && name.substr(name.size() - 3) == ".fy" ? 0.65 : 0.8) << name;
      EXPECT_LT(ratio, name.rfind("camera.p", 0) == 0 ? 1.5 : 1.2) << name;
    }
  }
}

/// The rig file again, for one who locates surfaces by the camera, where shared errors cancel.
TEST(RealCaptures, ThePredictedErrorIsCheckedForTheSurfaceOfTheUser) {
  PROCAM_REQUIRE_TEST_DATA("graycode/capture_0");
  const ScratchFolder folder;
  const std::string rig = (folder / "rig.json").string();
  const ToolRun run = run_tool("calibrate-projector",
                               "--captures " + (test_data() / "graycode").string() +
                                   " --pattern gray --projector-size 1024x768 --board chessboard:7x9:75mm "
                                   "--surface-located camera -o " +
                                   rig);
  EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
  EXPECT_EQ(run.out.rfind("result     passed: predicted error ", 0), 0u) << run.out;
  EXPECT_NE(run.out.find("surface located externally"), std::string::npos) << run.out;
  // 5 boards with 3 kinds of decoding notes: a line for each kind, not 15; 11 more of what is special here
  // (glare that differs by two between two views, poorly constrained terms).
  EXPECT_LE(std::count(run.err.begin(), run.err.end(), '\n'), 14) << run.err;
  EXPECT_NE(run.err.find("note: 5 views: decoded row codes "), std::string::npos) << run.err;

  const auto check = [&](const std::string& options) {
    return run_tool("calibrate-projector", "--check " + rig + options).exit_code;
  };
  EXPECT_EQ(check(" --accept 2mm"), 5);
  EXPECT_EQ(check(" --accept 2mm --surface-located camera"), 0);
  EXPECT_EQ(check(" --accept 0.2mm --surface-located camera"), 5);
  EXPECT_EQ(check(" --accept 100mm"), 0);
}

TEST(RealCaptures, GateFiresOnThePublishedCalibrationOfThem) {
  PROCAM_REQUIRE_TEST_DATA("graycode/upstream_calibration_result.xml");
  const ToolRun run =
      run_tool("calibrate-projector",
               "--check " + (test_data() / "graycode/upstream_calibration_result.xml").string() +
                   " --projector-size 1024x768");
  EXPECT_EQ(run.exit_code, 5) << run.err;
  EXPECT_NE(run.out.find("check FAILED projector lens shift"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("check FAILED projector RMS"), std::string::npos) << run.out;
}

/// 13 pairs, 640x480; the square's side is not known and taken as 25 mm.
Correspondences stereo_chessboards() {
  const Chessboard board{9, 6, 0.025};
  std::vector<session::BoardView> views;
  for (const char* number : {"01", "02", "03", "04", "05", "06", "07", "08", "09", "11", "12", "13", "14"}) {
    session::BoardView& view = views.emplace_back(session::BoardView{number, {}});
    for (const char* side : {"left", "right"}) {
      const auto file = test_data() / "chessboard" / (side + std::string(number) + ".jpg");
      view.detections.push_back(detect::detect_chessboard(io::to_gray(io::load_image(file).image), board));
    }
  }
  const ImageSize size{640, 480};
  return session::join(board, {{"left", DeviceKind::kCamera, size}, {"right", DeviceKind::kCamera, size}},
                       views);
}

TEST(StereoChessboards, AreExplainedBetterThanByOpenCVAndBetterStillWithTheirShape) {
  PROCAM_REQUIRE_TEST_DATA("chessboard/left01.jpg");
  const Correspondences data = stereo_chessboards();
  for (const View& view : data.views)
    for (const auto& observations : view.observations) EXPECT_EQ(observations.size(), 54u) << view.name;

  calibrate::Options options;
  options.outlier_sigmas = 0;  // every point counts
  options.board_shape = calibrate::BoardShape::kFlat;
  const calibrate::CalibrationResult flat = calibrate::calibrate_rig(data, options);
  EXPECT_LE(flat.rms_px[0], 0.195);  // calibrateCamera's, of each camera by itself
  EXPECT_LE(flat.rms_px[1], 0.207);
  EXPECT_LE(flat.joint_rms_px, 0.18);  // stereoCalibrate: 0.215
  const Vec3 right_in_squares = flat.rig.cameras[1].rig_from_camera.translation / 0.025;
  EXPECT_NEAR(right_in_squares.x(), 3.327, 0.02);
  EXPECT_NEAR(right_in_squares.y(), -0.037, 0.03);
  EXPECT_NEAR(flat.rig.cameras[0].camera.intrinsics.fx, 533.4, 2);
  EXPECT_NEAR(flat.rig.cameras[1].camera.intrinsics.fx, 537.0, 2);

  options.board_shape = calibrate::BoardShape::kAuto;
  const calibrate::CalibrationResult shaped = calibrate::calibrate_rig(data, options);
  EXPECT_TRUE(shaped.shape.free);
  EXPECT_LE(shaped.joint_rms_px, 0.10);
  EXPECT_LT(shaped.shape.holdout_free_px, 0.6 * shaped.shape.holdout_flat_px);
  // Changes of 1.4 px in every view explain a waving sheet as well, and predict other views to 2.5 px.
  EXPECT_EQ(shaped.diagnostics.find("image_changes"), nullptr);
}

}  // namespace
}  // namespace procam::test
