/// A session of images, its observations as a file, and the same calibration from that file.
#include <gtest/gtest.h>

#include <cmath>

#include "e2e/small_session.hpp"
#include "e2e/tool_runner.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/session/observations_file.hpp"

namespace procam::test {
namespace {

void expect_same_camera(const Camera& a, const Camera& b) {
  const VecX left = parameters_of(a), right = parameters_of(b);
  ASSERT_EQ(left.size(), right.size());
  EXPECT_LE((left - right).lpNorm<Eigen::Infinity>(), 1e-9);
}

/// Everything that follows from the observations: lens models, the board's shape, poses, covariance, held-out
/// error.
TEST(ObservationsRoute, TheFileGivesTheRigOfTheImages) {
  const ScratchFolder folder;
  const std::string table = (folder / "found.csv").string();
  const ToolRun images = run_tool("calibrate-projector", "--captures " + kSession.string() +
                                                             " --holdout --json --write-observations " +
                                                             table + " -o " + (folder / "a.json").string());
  ASSERT_EQ(images.exit_code, 0) << images.err;
  const ToolRun file = run_tool("calibrate-projector", "--observations " + table + " --holdout --json -o " +
                                                           (folder / "b.json").string());
  ASSERT_EQ(file.exit_code, 0) << file.err;
  const Rig a = io::load_rig(folder / "a.json"), b = io::load_rig(folder / "b.json");
  expect_same_camera(a.camera().camera, b.camera().camera);
  expect_same_camera(a.projector().projector.inverse_camera, b.projector().projector.inverse_camera);
  EXPECT_LE(
      (a.projector().rig_from_projector.translation - b.projector().rig_from_projector.translation).norm(),
      1e-9);
  EXPECT_LE(
      a.projector().rig_from_projector.rotation.angularDistance(b.projector().rig_from_projector.rotation),
      1e-9);
  ASSERT_EQ(a.covariance.names, b.covariance.names);
  for (const std::string& name : a.covariance.names)
    EXPECT_NEAR(b.covariance.sigma(name) / a.covariance.sigma(name), 1, 1e-9) << name;
  for (const char* figure : {"/rms_px/joint", "/holdout_px/projector", "/wall/rms_mm", "/views_used"}) {
    const nlohmann::json::json_pointer at(figure);
    EXPECT_NEAR(images.json().at(at).get<double>(), file.json().at(at).get<double>(), 1e-9) << figure;
  }
  EXPECT_EQ(b.provenance.inputs.front().path, "found.csv");
  EXPECT_EQ(b.provenance.options.at("board"), a.provenance.options.at("board"));

  // A table with less in it, as another program writes it: positions instead of points, no covariance.
  const std::string plain = (folder / "plain.csv").string();
  const Correspondences found = io::load_observations(table);
  const Points3 points = points_in_board(found.board);
  std::string text = "view,device,x,y,z,u,v\n";
  for (const View& view : found.views)
    for (std::size_t d = 0; d < 2; ++d)
      for (const Observation& o : view.observations[d]) {
        char line[200];
        std::snprintf(line, sizeof line, "%s,%d,%.6f,%.6f,0,%.6f,%.6f\n", view.name.c_str(), int(d),
                      points[std::size_t(o.point)].x(), points[std::size_t(o.point)].y(), o.pixel.x(),
                      o.pixel.y());
        text += line;
      }
  std::ofstream(plain) << text;
  const std::string sizes = " --camera-size " + std::to_string(found.devices[0].size.width) + "x" +
                            std::to_string(found.devices[0].size.height) + " --projector-size " +
                            std::to_string(found.devices[1].size.width) + "x" +
                            std::to_string(found.devices[1].size.height);
  const ToolRun run = run_tool("calibrate-projector", "--observations " + plain + sizes + " --truth " +
                                                          (kSession / "truth.json").string() + " --json -o " +
                                                          (folder / "c.json").string());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  // The covariances of the detectors are not in the table: the answer moves by part of its sigma, no more.
  EXPECT_LT(run.json().at("truth").at("rms_mm").get<double>(),
            3 * run.json().at("wall").at("rms_mm").get<double>());

  const ToolRun no_size =
      run_tool("calibrate-projector", "--observations " + plain + " -o " + (folder / "d.json").string());
  EXPECT_EQ(no_size.exit_code, 3);
  EXPECT_NE(no_size.err.find("--camera-size 1280x1024"), std::string::npos) << no_size.err;
}

/// What would be ignored is a usage error that names it.
TEST(ObservationsRoute, OptionsWithoutEffectAreRefused) {
  const auto refusal = [](const std::string& arguments) {
    const ToolRun run = run_tool("calibrate-projector", arguments);
    EXPECT_EQ(run.exit_code, 2) << arguments;
    return run.err;
  };
  const auto expect = [&](const std::string& arguments, const std::string& words) {
    const std::string err = refusal(arguments);
    EXPECT_NE(err.find(words), std::string::npos) << err;
  };
  expect("--points p.csv -o r.json --board-shape flat", "--board-shape: has no effect with --points");
  expect("--points p.csv -o r.json --camera-model none", "--camera-model: has no effect with --points");
  expect("--points p.csv -o r.json --holdout", "--holdout: has no effect with --points");
  expect("--points p.csv -o r.json --report r.html", "--report: has no effect with --points");
  expect("--points p.csv -o r.json --free k3", "--free k3: has no effect with --points");
  expect("--observations o.csv -o r.json --step 2", "--step: has no effect with --observations");
  expect("--captures c -o r.json --unit 1mm", "--unit: has no effect with --captures");
  expect("--check r.json --holdout", "--holdout: has no effect with --check");
  expect("--captures c --points p.csv -o r.json", "cannot be used together");
  expect("--observations o.csv", "-o rig.json");
}

}  // namespace
}  // namespace procam::test
