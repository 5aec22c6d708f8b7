/// calibrate-projector with what people know of their devices before: does it reach the solve, and is it told
/// apart from what the views say? And the view to add next, as the program says it.
#include <gtest/gtest.h>

#include "e2e/small_session.hpp"
#include "e2e/tool_runner.hpp"
#include "procam/io/rig_file.hpp"

namespace procam::test {
namespace {

/// The session's four views alone know the lenses' fx, fy, cx, cy to 0.06 to 0.13 px. What is known here is
/// three times better where it speaks, and silent elsewhere: the throw ratio of the projector's fx, the lens
/// shift of its cy (in x the sheet says next to nothing), a camera's file of its first four parameters; what
/// that file states without a sigma stays. None moves the truth out of three sigmas: 18 parameters, one let
/// pass.
TEST(KnownBefore, EntersASessionsSolve) {
  constexpr double kKnown = 0.02;  // pixels
  const Rig truth = io::load_rig(kSession / "truth.json");
  Rig known;
  known.cameras.push_back({"webcam", truth.camera().camera, Pose()});  // named otherwise than here
  known.covariance.names = {"webcam.fx", "webcam.fy", "webcam.cx", "webcam.cy"};
  known.covariance.matrix = kKnown * kKnown * MatX::Identity(4, 4);
  const ScratchFolder folder;
  io::save_rig(folder / "camera.json", known);
  const Projector& projector = truth.projector().projector;
  char sheet[160];
  std::snprintf(sheet, sizeof sheet, " --throw-ratio %.9f+-%.9f --lens-shift 0+-0.9,%.9f+-%.9f",
                projector.throw_ratio(), kKnown / projector.size().width, projector.lens_shift().y(),
                kKnown / projector.size().height);

  const ToolRun run = run_tool(
      "calibrate-projector",
      "--captures " + kSession.string() + " --truth " + (kSession / "truth.json").string() +
          " --camera-model brown-conrady --projector-model brown-conrady --board-shape flat --json -o " +
          (folder / "rig.json").string() + " --known-camera " + (folder / "camera.json").string() + sheet);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json said = run.json();
  const auto sigma_of = [&](const char* device, const char* name) {
    return said.at(device).at("sigma").at(name).get<double>();
  };
  EXPECT_LE(sigma_of("projector", "fx"), kKnown);
  EXPECT_LE(sigma_of("projector", "cy"), kKnown);
  EXPECT_GT(sigma_of("projector", "cx"), 1.5 * kKnown);
  for (const char* name : {"fx", "fy", "cx", "cy"}) {
    EXPECT_LE(sigma_of("camera", name), kKnown) << name;
    EXPECT_GT(sigma_of("camera", name), 0.1 * kKnown) << name;
  }
  EXPECT_EQ(sigma_of("camera", "k1"), 0);
  EXPECT_EQ(said.at("camera").at("k1").get<double>(),
            coefficients_of(truth.camera().camera.distortion).front());
  EXPECT_GE(said.at("truth").at("parameters_inside_3_sigma"), 17);

  EXPECT_LT(said.at("next_view").at("rms_mm"), said.at("wall").at("rms_mm"));
  EXPECT_NE(said.at("next_view").at("words").get<std::string>().find("m away, in the "), std::string::npos);
}

}  // namespace
}  // namespace procam::test
