/// export-warp and export-camera as programs: what they write is what procam itself would draw.
#include <gtest/gtest.h>

#include <cmath>

#include "e2e/tool_runner.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/io/exchange/mpcdi.hpp"
#include "procam/io/exchange/warp_file.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "support/expect_error.hpp"

namespace procam::test {
namespace {

/// A skewed, distorted projector with lens shift, a sheet turned by 47 degrees, placed in the world, and a
/// quad that was dragged in the picture.
class ExchangeRoute : public ::testing::Test {
 protected:
  void SetUp() override {
    Rig rig;
    rig.cameras.push_back({"camera", Camera{{640, 480}, {600, 610, 320, 240, 0}, NoDistortion{}}, Pose()});
    rig.projectors.push_back(
        {"beamer", projector_, Pose(so3_exp(Vec3(0.1, -0.2, 0.05)), Vec3(0.2, -0.1, 0.05))});
    io::save_rig(folder_ / "rig.json", rig);
    io::save_pose(folder_ / "pose.json", {"projector", "world", {projector_from_world_, Mat6::Zero()}});

    Surface sheet;
    sheet.name = "wall";
    PlanarSurface plane;
    plane.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    plane.points = {{0, 0}, {0.5, 0}, {0.5, 0.4}, {0, 0.4}};
    plane.frame_from_surface =
        projector_from_world_.inverse() *
        Pose(so3_exp<double>(Vec3(0.05, 47 * kDegree, -0.03)), Vec3(-0.12, -0.55, 1.6));
    sheet.geometry = plane;
    Surface quad;
    quad.name = "quad";
    PixelSurface pixels;
    pixels.content = plane.content;
    pixels.pixels = {{20, 30}, {100, 25}, {110, 90}, {15, 95}};
    quad.geometry = pixels;
    SurfaceSet set;
    set.surfaces = {sheet, quad};
    io::save_surfaces(folder_ / "surfaces.json", set);
    const ToolRun solved =
        run_tool("solve-surfaces", "--rig " + at("rig.json") + " --surfaces " + at("surfaces.json") +
                                       " --pose " + at("pose.json") + " -o " + at("solved.json"));
    ASSERT_EQ(solved.exit_code, 0) << solved.err;
  }

  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  ToolRun export_warp(const std::string& output, const std::string& more) {
    return run_tool("export-warp", "--rig " + at("rig.json") + " --surfaces " + at("solved.json") + " -o " +
                                       at(output) + " " + more);
  }

  const Projector projector_{
      Camera{{160, 120}, {293, 288, 77.3, 133.6, 0.9}, BrownConrady{{-0.15, 0.02, 0.001, -0.0007, 0}}}};
  const Pose projector_from_world_ = Pose(so3_exp(Vec3(-0.2, 0.3, 0.1)), Vec3(0.4, -0.2, 0.3));
  ScratchFolder folder_;
};

// A picture whose red is u and green v: the frame that render-to-image draws says where it took each pixel
// from.
TEST_F(ExchangeRoute, MapsSayWhereTheRendererTakesEachPixelFrom) {
  ImageU8 picture(256, 256, 3, 128);
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 256; ++x) {
      picture.at(x, y, 0) = std::uint8_t(x);
      picture.at(x, y, 1) = std::uint8_t(y);
    }
  io::save_image(folder_ / "picture.png", picture);
  const ToolRun drawn = run_tool(
      "render-to-image", "--average-numbers --rig " + at("rig.json") + " --surfaces " + at("solved.json") +
                             " --content wall=" + at("picture.png") + " -o " + at("frame.png"));
  ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  const ImageU8 frame = io::load_image(folder_ / "frame.png").image;
  for (const std::string file : {"warp.pfm", "warp.png"}) {
    const ToolRun run = export_warp(file, "--surface wall --json");
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_GT(run.json()["shown_share"].get<double>(), 0.1);
    const WarpMap map = io::load_warp_map(folder_ / file);
    ASSERT_EQ(map.size(), frame.size());
    int compared = 0;
    for (int y = 1; y < 119; ++y)
      for (int x = 1; x < 159; ++x) {
        bool inside = true;  // its neighbours too: at its edge the content is mixed with the dark around it
        for (const int d : {-1, 1}) inside = inside && map.shows(x + d, y) && map.shows(x, y + d);
        if (!inside) continue;
        ++compared;
        EXPECT_NEAR(frame.at(x, y, 0), 256 * map.at(x, y).x() - 0.5, 1.5) << x << " " << y;
        EXPECT_NEAR(frame.at(x, y, 1), 256 * map.at(x, y).y() - 0.5, 1.5) << x << " " << y;
      }
    EXPECT_GT(compared, 1000);
  }
  EXPECT_EQ(export_warp("warp.exr", "--surface quad").exit_code, 0);
}

TEST_F(ExchangeRoute, MeshSaysHowFarItIsOff) {
  const ToolRun coarse = export_warp("coarse.obj", "--surface wall --grid 2x2 --json");
  ASSERT_EQ(coarse.exit_code, 0) << coarse.err;
  EXPECT_GT(coarse.json()["mesh_error_px"].get<double>(), 0.25);
  EXPECT_NE(coarse.err.find("finer --grid"), std::string::npos) << coarse.err;
  const ToolRun fine = export_warp("fine.obj", "--surface wall --json");
  EXPECT_LT(fine.json()["mesh_error_px"].get<double>(), 0.01);
  const WarpMesh mesh = io::load_warp_mesh(folder_ / "fine.obj", projector_.size());
  EXPECT_EQ(int(mesh.triangles.size()), fine.json()["triangles"].get<int>());
}

TEST_F(ExchangeRoute, ShaderLampPutsItsPositionsUnderItsOwnLight) {
  const ToolRun run = export_warp("wall.mpcdi", "--surface wall --profile sl --json");
  if (run.exit_code == 3 && run.err.find("libzip") != std::string::npos)
    GTEST_SKIP() << "built without libzip";
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.json()["diagnostics"][0]["code"], "frustum_is_not_lens");
  const io::Mpcdi mpcdi = io::load_mpcdi(folder_ / "wall.mpcdi");
  const io::MpcdiRegion& region = mpcdi.regions.at(0);
  EXPECT_EQ(region.id, "beamer");
  const Projector frustum = io::projector_of(region);
  const Pose projector_from_file = io::world_from_projector(region).inverse();
  int compared = 0;
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) {
      const Vec3 point(region.positions->at(x, y, 0), region.positions->at(x, y, 1),
                       region.positions->at(x, y, 2));
      EXPECT_EQ(point.allFinite(), region.alpha->at(x, y) == 1);
      if (!point.allFinite()) continue;
      ++compared;
      const Vec2 uv = region.distortion->at(x, y);
      EXPECT_LT((*frustum.project(projector_from_file * point) - Vec2(uv.x() * 160 - 0.5, uv.y() * 120 - 0.5))
                    .norm(),
                1e-3);
    }
  EXPECT_GT(compared, 1000);
  // The world's z is up, and the file's y: the point that the projector stands at.
  const Vec3 eye = projector_from_world_.inverse().translation;
  EXPECT_LT((region.frame->position - Vec3(-eye.y(), eye.z(), -eye.x())).norm(), 1e-12);

  for (const std::string profile : {"2d", "a3"})
    EXPECT_EQ(export_warp(profile + ".mpcdi", "--surface wall --profile " + profile).exit_code, 0);
  EXPECT_TRUE(io::load_mpcdi(folder_ / "2d.mpcdi").regions[0].warp);
  EXPECT_TRUE(io::load_mpcdi(folder_ / "a3.mpcdi").regions[0].positions);
}

// Two walls in one buffer: each pixel has the place where its light lands first.
TEST_F(ExchangeRoute, PositionsHoldAllSurfaces) {
  SurfaceSet set = io::load_surfaces(folder_ / "surfaces.json");
  Surface post = set.surfaces[0];
  post.name = "post";
  auto& plane = std::get<PlanarSurface>(post.geometry);
  plane.points = {{0.1, 0.1}, {0.2, 0.1}, {0.2, 0.6}, {0.1, 0.6}};
  plane.frame_from_surface.translation -=
      0.3 * (plane.frame_from_surface.translation - projector_from_world_.inverse().translation);
  set.surfaces = {post, set.surfaces[0]};
  io::save_surfaces(folder_ / "surfaces.json", set);
  ASSERT_EQ(run_tool("solve-surfaces", "--rig " + at("rig.json") + " --surfaces " + at("surfaces.json") +
                                           " --pose " + at("pose.json") + " -o " + at("solved.json"))
                .exit_code,
            0);
  const ToolRun all = export_warp("all.mpcdi", "--profile a3");
  if (all.exit_code == 3 && all.err.find("libzip") != std::string::npos)
    GTEST_SKIP() << "built without libzip";
  ASSERT_EQ(all.exit_code, 0) << all.err;
  ASSERT_EQ(export_warp("post.mpcdi", "--profile a3 --surface post").exit_code, 0);
  ASSERT_EQ(export_warp("wall.pfm", "--surface wall").exit_code, 0);
  const auto both = io::load_mpcdi(folder_ / "all.mpcdi").regions[0],
             one = io::load_mpcdi(folder_ / "post.mpcdi").regions[0];
  const WarpMap wall = io::load_warp_map(folder_ / "wall.pfm");
  int of_post = 0, of_wall = 0;
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) {
      const bool there = std::isfinite(both.positions->at(x, y, 0)),
                 post_there = std::isfinite(one.positions->at(x, y, 0));
      EXPECT_EQ(there, post_there || wall.shows(x, y));
      EXPECT_FALSE(post_there && wall.shows(x, y)) << "the post hides the wall";
      EXPECT_EQ(both.alpha->at(x, y), there ? 1 : 0);
      if (post_there) {
        EXPECT_EQ(both.positions->at(x, y, 2), one.positions->at(x, y, 2));
      }
      of_post += post_there;
      of_wall += wall.shows(x, y);
    }
  EXPECT_GT(of_post, 100);
  EXPECT_GT(of_wall, 500);
}

TEST_F(ExchangeRoute, ExportWarpSaysWhatItCannotDo) {
  const auto refuse = [&](const std::string& output, const std::string& more, const std::string& why,
                          int code = 3) {
    const ToolRun run = export_warp(output, more);
    EXPECT_EQ(run.exit_code, code) << run.err;
    EXPECT_NE(run.err.find(why), std::string::npos) << run.err;
    EXPECT_FALSE(std::filesystem::exists(folder_ / output));
  };
  refuse("x.pfm", "", "give --surface with one of: wall, quad");
  refuse("x.pfm", "--surface roof", "give --surface with one of: wall, quad");
  refuse("x.jpg", "--surface wall", ".pfm, .png or .exr");
  refuse("x.png", "--surface wall --profile sl", "--profile");
  refuse("x.pfm", "--surface wall --grid 4x4", "--grid");
  refuse("x.obj", "--surface wall --world-up y", "--world-up");
  refuse("x.obj", "--surface wall --grid 4000x4", "1024 cells", 2);
  refuse("x.mpcdi", "--surface wall --profile 4d", "give 2d, 3d, sl or a3", 2);
  refuse("x.mpcdi", "--surface wall --profile 3d", "profile 3d is read, not written");
  refuse("x.mpcdi", "--surface quad --profile a3", "not in the room");
}

TEST_F(ExchangeRoute, ExportCameraPrintsOrWritesTheSettings) {
  const std::string base = "--rig " + at("rig.json") + " --for blender ";
  const ToolRun printed = run_tool("export-camera", base + "--pose " + at("pose.json"));
  ASSERT_EQ(printed.exit_code, 0) << printed.err;
  EXPECT_NE(printed.out.find("camera.data.shift_y = "), std::string::npos) << printed.out;
  EXPECT_NE(printed.err.find("cannot model lens distortion"), std::string::npos) << printed.err;
  const ToolRun written = run_tool("export-camera", base + "--near 5cm --json -o " + at("camera.py"));
  ASSERT_EQ(written.exit_code, 0) << written.err;
  EXPECT_EQ(written.json()["world"], "rig");
  EXPECT_EQ(written.json()["settings"]["clip"][0], 0.05);
  EXPECT_NE(slurp(folder_ / "camera.py").find("matrix_world"), std::string::npos);
  EXPECT_EQ(run_tool("export-camera", base + "--near 2m --far 1m").exit_code, 3);
  EXPECT_EQ(run_tool("export-camera", "--rig " + at("rig.json") + " --for maya").exit_code, 2);
}

TEST_F(ExchangeRoute, CalibrationsGoThereAndBack) {
  const ToolRun there =
      run_tool("procam-convert", at("rig.json") + " --format opencv-stereo -o " + at("pair.yml"));
  ASSERT_EQ(there.exit_code, 0) << there.err;
  EXPECT_TRUE(contains(there.out + there.err, "OpenCV's functions do not use it"));
  const ToolRun back = run_tool("procam-convert", at("pair.yml") + " --format procam -o " + at("back.json"));
  ASSERT_EQ(back.exit_code, 0) << back.err;
  const Rig first = io::load_rig(folder_ / "rig.json"), second = io::load_rig(folder_ / "back.json");
  EXPECT_EQ(parameters_of(first.projector().projector.inverse_camera),
            parameters_of(second.projector().projector.inverse_camera));
  EXPECT_LT((first.projector_from_camera().matrix() - second.projector_from_camera().matrix()).norm(), 1e-14);

  const ToolRun printed = run_tool("procam-convert", at("rig.json") + " --format ros --device beamer");
  EXPECT_EQ(printed.exit_code, 0);
  EXPECT_TRUE(contains(printed.out, "camera_name: beamer")) << printed.out;
  EXPECT_EQ(run_tool("procam-convert", at("rig.json") + " --format ros").exit_code, 3);
  EXPECT_EQ(run_tool("procam-convert", at("rig.json") + " --format procam").exit_code, 3);
  EXPECT_EQ(run_tool("procam-convert", at("rig.json") + " --format autocad").exit_code, 2);
  EXPECT_EQ(run_tool("procam-convert", at("solved.json") + " --format ros").exit_code, 3);
  EXPECT_EQ(run_tool("procam-convert", at("rig.json") + " --format procam --device beamer -o " + at("b.json"))
                .exit_code,
            3);

  io::Mount mount;
  mount.pose = {"base", "rig", {Pose(so3_exp(Vec3(0.1, 0.2, 0.3)), Vec3(0.1, 0, 0.7)), Mat6::Zero()}};
  io::save_mount(folder_ / "mount.json", mount);
  const ToolRun urdf =
      run_tool("procam-convert", at("rig.json") + " --format urdf --mount " + at("mount.json"));
  EXPECT_EQ(urdf.exit_code, 0) << urdf.err;
  EXPECT_TRUE(contains(urdf.out, "<joint name=\"base_to_rig\" type=\"fixed\">")) << urdf.out;
  EXPECT_EQ(
      run_tool("procam-convert", at("rig.json") + " --format kalibr --mount " + at("mount.json")).exit_code,
      3);
}

}  // namespace
}  // namespace procam::test
