/// Pictures of lit boards in a mirror, and one of the mirror's own board -> calibrate-projector -> the rig.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "procam/core/geometry/mirror.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/pattern/gray_code.hpp"
#include "procam/simulate/capture.hpp"
#include "small_stage.hpp"
#include "tool_runner.hpp"

namespace procam::test {
namespace {

namespace fs = std::filesystem;

simulate::CaptureOptions webcam(std::uint64_t seed) {
  simulate::CaptureOptions options;
  options.camera_blur_px = 0.5;
  options.noise = {0.5, 0.004};
  options.seed = seed;
  options.samples_per_axis = 2;
  return options;
}

/// What the camera itself took: the mirrored camera's picture, turned back.
void save_turned(const fs::path& file, ImageU8 image) {
  for (int y = 0; y < image.height(); ++y) std::reverse(image.row(y), image.row(y) + image.width());
  io::save_image(file, image);
}

TEST(Mirror, ShowsTheLightOfAProjectorThatTheCameraCannotSee) {
  const ScratchFolder scratch;
  const auto frames = pattern::frames(pattern::GrayCode{kStageProjector});
  for (int pose = 0; pose < kStagePoses; ++pose) {
    const fs::path folder = scratch / "session" / ("pose_" + std::to_string(pose));
    fs::create_directories(folder);
    const auto captures = simulate::capture(stage(pose), frames, webcam(std::uint64_t(pose)));
    for (std::size_t f = 0; f < captures.size(); ++f)
      save_turned(folder / ("f" + std::to_string(f) + ".png"), captures[f]);
  }

  // The camera behind the stage's, and the mirror's own board before it.
  const RigCamera mirrored = stage_rig().camera();
  const RigProjector projector = stage_rig().projector();
  simulate::World mirror;
  mirror.rig.cameras = {{"camera", turned_left_to_right(mirrored.camera), Pose()}};
  mirror.rig.projectors = {
      {"lamp", projector.projector, Pose(so3_exp<double>(Vec3(0, 0.1, 0)), Vec3(0.05, 0, 0))}};
  mirror.board.layout = Chessboard{7, 6, 0.03};
  mirror.board.margin = 0.01;
  mirror.rig_from_board = Pose(so3_exp<double>(Vec3(0.24, -0.35, 0.08)), Vec3(-0.11, -0.09, 0.45));
  mirror.ambient = 50;  // the room's light alone
  const ImageU8 dark(kStageProjector);
  io::save_image(scratch / "mirror.png", simulate::capture(mirror, {dark}, webcam(9)).front());

  const Plane plane = Plane::of_xy(mirror.rig_from_board);
  Rig truth = mirror.rig;
  truth.projectors = {
      {"projector", projector.projector, camera_from_mirrored_camera(plane) * projector.rig_from_projector}};
  io::save_rig(scratch / "truth.json", truth);
  const std::string common =
      "--captures " + (scratch / "session").string() +
      " --projector-size 320x240 --board chessboard:8x5:45mm --board-shape flat --json -o " +
      (scratch / "rig.json").string() + " --truth " + (scratch / "truth.json").string() + " --mirror-view " +
      (scratch / "mirror.png").string();
  const ToolRun run = run_tool("calibrate-projector", common + " --mirror-board chessboard:7x6:30mm");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto summary = run.json();
  EXPECT_NEAR(summary["mirror"]["distance_m"], std::abs(plane.offset), 0.002);
  const double predicted = summary["wall"]["rms_mm"], off = summary["truth"]["rms_mm"];
  std::printf("light at 2 m off by %.2f mm rms, predicted %.2f\n", off, predicted);
  EXPECT_LT(predicted, 30);
  EXPECT_LT(off, 4 * predicted);  // four times the rms of 2-D Gaussians: never
  EXPECT_EQ(run_tool("calibrate-projector", common).exit_code, 3) << "no board on the mirror was stated";
}

}  // namespace
}  // namespace procam::test
