/// calibrate-projector with what people know of their devices before: does it reach the solve, and is it told
/// apart from what the views say? And the view to add next, as the program says it.
#include <gtest/gtest.h>

#include "e2e/tool_runner.hpp"
#include "procam/io/rig_file.hpp"

namespace procam::test {
namespace {

const std::filesystem::path kSession = PROCAM_E2E_SESSION;

nlohmann::json calibrated(const std::string& more) {
  const ScratchFolder folder;
  const ToolRun run = run_tool(
      "calibrate-projector",
      "--captures " + kSession.string() + " --truth " + (kSession / "truth.json").string() +
          " --camera-model brown-conrady --projector-model brown-conrady --board-shape flat --json -o " +
          (folder / "rig.json").string() + " " + more);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return run.json();
}

/// Four views know the lenses to a pixel or so; each source of knowledge is better than that where it speaks,
/// and silent elsewhere: the throw ratio of fx, the lens shift of cy alone (that in x is stated as hardly
/// known), the camera's file of its lens. None moves the truth out of its sigmas: 22 parameters, false alarm
/// under 6 %, two let pass.
TEST(KnownBefore, EntersASessionsSolve) {
  const Rig truth = io::load_rig(kSession / "truth.json");
  const nlohmann::json free = calibrated("");
  const auto sigma_of = [](const nlohmann::json& said, const char* device, const char* name) {
    return said.at(device).at("sigma").at(name).get<double>();
  };

  Rig known;
  known.cameras.push_back({"webcam", truth.camera().camera, Pose()});  // named otherwise than here
  const std::vector<std::string> names = parameter_names(truth.camera().camera);
  known.covariance.names = {"webcam.fx", "webcam.fy", "webcam.cx", "webcam.cy"};
  Eigen::Vector4d known_sigma;
  for (int i = 0; i < 4; ++i) known_sigma[i] = 0.4 * sigma_of(free, "camera", names[std::size_t(i)].c_str());
  known.covariance.matrix = known_sigma.cwiseAbs2().asDiagonal();
  const ScratchFolder folder;
  io::save_rig(folder / "camera.json", known);

  const Projector& projector = truth.projector().projector;
  const double fx_sigma = 0.4 * sigma_of(free, "projector", "fx"),
               cy_sigma = 0.4 * sigma_of(free, "projector", "cy");
  char flags[240];
  std::snprintf(flags, sizeof flags, " --throw-ratio %.6f+-%.7f --lens-shift 0+-0.9,%.6f+-%.7f",
                projector.throw_ratio(), fx_sigma / projector.size().width, projector.lens_shift().y(),
                cy_sigma / projector.size().height);

  const nlohmann::json sheet = calibrated(flags);
  EXPECT_LE(sigma_of(sheet, "projector", "fx"), fx_sigma);
  EXPECT_LE(sigma_of(sheet, "projector", "cy"), cy_sigma);
  EXPECT_GE(sigma_of(sheet, "projector", "cx"), 0.5 * sigma_of(free, "projector", "cx"));
  EXPECT_GE(sheet.at("truth").at("parameters_inside_3_sigma").get<int>(),
            sheet.at("truth").at("parameters").get<int>() - 2);

  const nlohmann::json camera = calibrated(" --known-camera " + (folder / "camera.json").string());
  for (int i = 0; i < 4; ++i) {
    const char* name = names[std::size_t(i)].c_str();
    EXPECT_LE(sigma_of(camera, "camera", name), known_sigma[i]) << name;
    EXPECT_GT(sigma_of(camera, "camera", name), 0.1 * known_sigma[i]) << name;
  }
  EXPECT_EQ(sigma_of(camera, "camera", "k1"), 0);  // of which the file has none
  EXPECT_EQ(camera.at("camera").at("k1").get<double>(),
            coefficients_of(truth.camera().camera.distortion).front());
  EXPECT_LT(camera.at("wall").at("rms_mm"), free.at("wall").at("rms_mm"));

  const nlohmann::json next = free.at("next_view");
  EXPECT_LT(next.at("rms_mm"), free.at("wall").at("rms_mm"));
  EXPECT_NE(next.at("words").get<std::string>().find("m away, in the "), std::string::npos);
}

}  // namespace
}  // namespace procam::test
