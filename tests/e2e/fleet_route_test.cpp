/// Two cameras and two projectors, in pictures: folders of captures -> calibrate-projector -> one rig.
#include <gtest/gtest.h>

#include <cstdio>
#include <random>
#include <set>

#include "procam/core/geometry/se3.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/session/captures.hpp"
#include "procam/pattern/gray_code.hpp"
#include "procam/simulate/capture.hpp"
#include "tool_runner.hpp"

namespace procam::test {
namespace {

namespace fs = std::filesystem;

/// 0 left, 1 right, 2 lamp, 3 beamer; small pictures.
Rig small_fleet() {
  Rig rig;
  rig.cameras = {{"left",
                  {{400, 300}, {430, 434, 206, 143, 0}, BrownConrady{{0.03, -0.02, 0.0006, -0.0004, 0}}},
                  Pose()},
                 {"right",
                  {{420, 300}, {452, 449, 213, 152, 0}, BrownConrady{{-0.02, 0.03, -0.0004, 0.0005, 0}}},
                  Pose(so3_exp<double>(Vec3(0.03, -0.36, 0.04)), Vec3(0.42, -0.03, 0.05))}};
  const Camera lamp{{320, 240}, {395, 391, 166, 133, 0}, BrownConrady{{-0.02, 0.01, 0.0003, 0.0005, 0}}};
  const Camera beamer{{300, 220}, {378, 381, 145, 121, 0}, BrownConrady{{0.01, 0.02, -0.0003, 0.0004, 0}}};
  rig.projectors = {
      {"lamp", Projector{lamp}, Pose(so3_exp<double>(Vec3(-0.07, -0.18, 0.02)), Vec3(0.22, -0.09, 0.03))},
      {"beamer", Projector{beamer},
       Pose(so3_exp<double>(Vec3(0.08, -0.10, -0.03)), Vec3(0.12, 0.13, -0.02))}};
  return rig;
}

simulate::World pair_of(const Rig& rig, const Pose& rig_from_board, std::size_t camera,
                        std::size_t projector) {
  simulate::World world;
  world.rig.cameras = {rig.cameras[camera]};
  world.rig.projectors = {rig.projectors[projector]};
  world.board.layout = Chessboard{8, 5, 0.042};
  world.board.margin = 0.02;
  world.ambient = 0.03;
  world.rig_from_board = rig_from_board;
  return world;
}

TEST(Fleet, IsCalibratedFromFoldersOfSeveralCamerasAndProjectors) {
  const ScratchFolder scratch;
  const Rig truth = small_fleet();
  const std::vector<std::set<int>> casts{{0, 1, 2, 3}, {0, 2}, {0, 1, 2, 3}, {1, 3},
                                         {0, 1, 2, 3}, {1, 3}, {0, 2}};
  std::mt19937_64 random(11);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (double(random() >> 11) * 0x1.0p-53);
  };
  for (std::size_t v = 0; v < casts.size();) {
    // In an order that no compiler may change.
    const double z = uniform(0.75, 1.1), y = uniform(-0.3, 0.1), x = uniform(-0.4, 0.2);
    const double about_z = uniform(-0.3, 0.3), about_y = uniform(-0.6, 0.4), about_x = uniform(-0.5, 0.5);
    const Pose pose(so3_exp<double>(Vec3(about_x, about_y, about_z)), Vec3(x, y, z));
    bool covered = true;
    for (const std::size_t c : {0u, 1u})
      for (const std::size_t p : {0u, 1u}) {
        if (casts[v].count(int(c)) + casts[v].count(2 + int(p)) < 2) continue;
        const simulate::World world = pair_of(truth, pose, c, p);
        covered = covered && simulate::board_in_camera(world).size() == 40 &&
                  simulate::board_in_projector(world).size() == 40;
        for (const Vec3& corner : simulate::sheet_corners_in_board(world.board)) {
          const RigCamera& camera = truth.cameras[c];
          const auto pixel = camera.camera.project(camera.rig_from_camera.inverse() * (pose * corner));
          covered = covered && pixel && camera.camera.size.contains(*pixel);
        }
      }
    if (!covered) continue;
    for (const std::size_t c : {0u, 1u})
      for (const std::size_t p : {0u, 1u}) {
        if (casts[v].count(int(c)) + casts[v].count(2 + int(p)) < 2) continue;
        const fs::path folder = scratch / "session" / ("pose_" + std::to_string(v)) /
                                truth.projectors[p].name / truth.cameras[c].name;
        fs::create_directories(folder);
        simulate::CaptureOptions options;
        options.camera_blur_px = 0.5;
        options.noise = {0.5, 0.004};
        options.seed = 100 * v + 10 * c + p;
        options.samples_per_axis = 2;
        const auto frames = simulate::capture(
            pair_of(truth, pose, c, p),
            pattern::frames(pattern::GrayCode{truth.projectors[p].projector.size()}), options);
        for (std::size_t f = 0; f < frames.size(); ++f)
          io::save_image(folder / ("f" + std::to_string(f) + ".png"), frames[f]);
      }
    ++v;
  }
  io::save_rig(scratch / "truth.json", truth);
  const std::string arguments = "--captures " + (scratch / "session").string() +
                                " --board chessboard:8x5:42mm --board-shape flat --truth " +
                                (scratch / "truth.json").string() + " --report " +
                                (scratch / "report.html").string() + " --json --accept 20mm -o " +
                                (scratch / "rig.json").string();
  const ToolRun run = run_tool("calibrate-projector",
                               "--projector-size lamp=320x240 --projector-size beamer=300x220 " + arguments);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto summary = run.json();
  EXPECT_EQ(summary["views_used"], 7);
  for (const char* name : {"lamp", "beamer"}) {
    const double predicted = summary["wall"][name]["rms_mm"], off = summary["truth"][name]["rms_mm"];
    std::printf("%s: light at 2 m off by %.2f mm rms, predicted %.2f\n", name, off, predicted);
    EXPECT_LT(predicted, 9) << name;  // seven views in small pictures: skew and k3 are poorly constrained
    EXPECT_LT(off, 4 * predicted) << name;  // four times the rms of 2-D Gaussians: never
  }
  // Of some 50 parameters the worst lie where small pictures' corners are biased: nearly all must be inside.
  const int inside = summary["truth"]["parameters_inside_3_sigma"], total = summary["truth"]["parameters"];
  EXPECT_GE(inside, total - 3) << total;
  const Rig rig = io::load_rig(scratch / "rig.json");
  ASSERT_EQ(rig.cameras.size(), 2u);
  EXPECT_EQ(rig.cameras[0].name, "left");
  EXPECT_EQ(rig.projectors[0].name, "beamer");
  const std::string page = slurp(scratch / "report.html");
  EXPECT_NE(page.find("redicted error of lamp at 2"), std::string::npos);

  const ToolRun unnamed = run_tool("calibrate-projector", "--projector-size 320x240 " + arguments);
  EXPECT_EQ(unnamed.exit_code, 3) << "folders that look like cameras' with cameras below";
}

}  // namespace
}  // namespace procam::test
