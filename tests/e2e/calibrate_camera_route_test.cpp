/// calibrate-camera from tables of observations and from photographs of different sizes.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "e2e/tool_runner.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/session/observations_file.hpp"
#include "support/numeric_world.hpp"
#include "support/test_data.hpp"

namespace procam::test {
namespace {

namespace fs = std::filesystem;

/// Arrays of numbers have no names of devices and no sizes: the camera alone.
Correspondences camera_alone(Correspondences data) {
  data.devices.resize(1);
  for (View& view : data.views) view.observations.resize(1);
  return data;
}

/// The table is a projector session's: rows of the projector are ignored. Every parameter within four sigmas
/// (ten of them: a false alarm in 0.06 %; the seed is fixed), with what sessions of images get besides.
TEST(CalibrateCameraFromObservations, FindsTheLens) {
  const ScratchFolder folder;
  const NumericWorld world = NumericWorld::make(10, 8, 0.05, 0.08);
  for (const char* const name : {"t.csv", "t.npy"}) {
    SCOPED_TRACE(name);
    const std::string table = (folder / name).string(), stem = (folder / "out").string();
    Correspondences data = world.correspondences(3);
    if (std::string(name) == "t.npy") data = camera_alone(data);
    io::save_observations(table, data);
    const std::string of_npy =
        std::string(name) == "t.npy" ? " --camera-size 1280x960 --board chessboard:9x6:35mm" : "";
    const ToolRun run =
        run_tool("calibrate-camera", "--observations " + table + of_npy + " --holdout --json -o " + stem +
                                         ".json --report " + stem + ".html");
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const Rig rig = io::load_rig(stem + ".json");
    ASSERT_TRUE(rig.projectors.empty());
    const VecX error = parameters_of(rig.camera().camera) - parameters_of(world.camera);
    const std::vector<std::string> names = parameter_names(world.camera);
    for (std::size_t i = 0; i < names.size(); ++i)
      EXPECT_LT(std::abs(error[Eigen::Index(i)]), 4 * rig.covariance.sigma("camera." + names[i])) << names[i];
    EXPECT_NEAR(run.json().at("/holdout_px/camera"_json_pointer).get<double>(), 0.05 * std::sqrt(2.0), 0.015);
    EXPECT_TRUE(run.json().contains("/lens_models/camera"_json_pointer));
    EXPECT_NE(slurp(stem + ".html").find(">Passed.<"), std::string::npos);
    EXPECT_EQ(rig.provenance.inputs.front().path, name);
  }
}

/// A sheet that sags by a millimetre is found as such from numbers too; with --board-shape flat the focal
/// length is farther off.
TEST(CalibrateCameraFromObservations, FindsTheShapeOfABentBoard) {
  const ScratchFolder folder;
  NumericWorld world = NumericWorld::make(12, 21, 0.03, 0.03);
  world.bend_board();
  const std::string table = (folder / "t.csv").string(), rig = (folder / "rig.json").string();
  io::save_observations(table, world.correspondences(4));
  const ToolRun run = run_tool("calibrate-camera", "--observations " + table + " --json -o " + rig);
  ASSERT_TRUE(run.exit_code == 0 || run.exit_code == 5) << run.err;
  EXPECT_TRUE(run.json().at("/board/free_shape"_json_pointer).get<bool>());
  const ToolRun flat =
      run_tool("calibrate-camera", "--observations " + table + " --board-shape flat --json -o " + rig);
  const auto rms = [](const ToolRun& one) { return one.json().at("rms_all_px").get<double>(); };
  EXPECT_LT(2 * rms(run), rms(flat));
}

TEST(CalibrateCameraFromObservations, NamesWhatIsMissing) {
  const ScratchFolder folder;
  const std::string table = (folder / "t.csv").string(), rig = " -o " + (folder / "r.json").string();
  std::ofstream(table) << "view,device,point,u,v\n0,0,0,10,20\n";
  const ToolRun no_size = run_tool("calibrate-camera", "--observations " + table + rig);
  EXPECT_EQ(no_size.exit_code, 3);
  EXPECT_NE(no_size.err.find("--camera-size 1280x1024"), std::string::npos) << no_size.err;
  EXPECT_EQ(run_tool("calibrate-camera", "--observations " + table + " --images x" + rig).exit_code, 2);
  EXPECT_EQ(run_tool("calibrate-camera", "--images x" + rig).exit_code, 2);
  EXPECT_EQ(run_tool("calibrate-camera", "--board chessboard:9x6:35mm" + rig).exit_code, 2);
}

/// A thumbnail among the photographs is rejected by name, whatever its place in the order; the rest is used.
TEST(CalibrateCameraFromImages, ThoseOfAnotherSizeAreRejectedByName) {
  PROCAM_REQUIRE_TEST_DATA("chessboard");
  const ScratchFolder folder;
  fs::create_directory(folder / "left");
  for (const char* const number : {"02", "03", "05", "07", "09", "12"}) {
    const std::string name = std::string("left") + number + ".jpg";
    fs::create_symlink(test_data() / "chessboard" / name, folder / ("left/" + name));
  }
  io::save_image(folder / "left/left01_small.png", ImageU8(320, 240, 1, 90));
  const ToolRun run = run_tool("calibrate-camera", "--images " + (folder / "left").string() +
                                                       " --board chessboard:9x6:25mm --json -o " +
                                                       (folder / "camera.json").string());
  ASSERT_TRUE(run.exit_code == 0 || run.exit_code == 5) << run.err;
  EXPECT_EQ(io::load_rig(folder / "camera.json").quality.views_used, 6);
  EXPECT_EQ(run.json().at("views"), 7);
  EXPECT_NE(run.err.find("left01_small.png is rejected: it is 320x240, the other images are 640x480"),
            std::string::npos)
      << run.err;
}

}  // namespace
}  // namespace procam::test
