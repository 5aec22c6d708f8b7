/// render-to-image --viewer: things that stand behind a wall, for an eye before it.
#include <gtest/gtest.h>

#include "e2e/plane_in_rig.hpp"
#include "e2e/tool_runner.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "support/numeric_world.hpp"

namespace procam::test {
namespace {

/// A wall, and a picture with one white square that stands 0.7 m behind it.
class ViewerRoute : public ::testing::Test {
 protected:
  void SetUp() override {
    const NumericWorld world;
    Rig rig;
    rig.cameras.push_back({"camera", world.camera, Pose()});
    rig.projectors.push_back(
        {"beamer", world.projector, Pose(so3_exp<double>(Vec3(0.01, -0.05, 0.02)), Vec3(0.15, 0.02, 0.1))});
    rig_ = rig;
    io::save_rig(folder_ / "rig.json", rig);
    SurfaceSet walls, things;
    walls.surfaces = {plane_in_rig("wall", 1.4, 1.1, rig_from_wall_)};
    things.surfaces = {plane_in_rig("far", 2, 1.6, rig_from_far_)};
    io::save_surfaces(folder_ / "walls.json", walls);
    io::save_surfaces(folder_ / "things.json", things);
    ImageU8 picture(200, 160, 3);
    for (int y = 63; y < 69; ++y)
      for (int x = 94; x < 100; ++x)
        for (int c = 0; c < 3; ++c) picture.at(x, y, c) = 255;
    io::save_image(folder_ / "far.png", picture);
    const ToolRun run = run_tool("solve-surfaces", "--rig " + at("rig.json") + " --surfaces " +
                                                       at("walls.json") + " -o " + at("solved.json"));
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  ToolRun render(const std::string& more) const {
    return run_tool("render-to-image", "--rig " + at("rig.json") + " --surfaces " + at("solved.json") +
                                           " -o " + at("frame.png") + " " + more);
  }

  ScratchFolder folder_;
  Rig rig_;
  const Vec3 eye_{-0.42, 0.11, 0.3};
  const Pose rig_from_wall_{so3_exp<double>(Vec3(0.05, 0.2, -0.03)), Vec3(-0.55, -0.85, 1.9)};
  const Pose rig_from_far_{so3_exp<double>(Vec3(-0.1, 0.1, 0.02)), Vec3(-0.85, -1.2, 2.6)};
};

TEST_F(ViewerRoute, DrawsThingsWhereTheEyeSeesThemThroughTheWall) {
  const ToolRun run = render("--viewer=-0.42m,110mm,30cm --virtual " + at("things.json") +
                             " --content far=" + at("far.png") + " --preview " + at("seen.png") + " --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_GT(run.json()["viewer"]["seen_share"].get<double>(), 0.9);
  // The square's middle, along the eye's ray on the wall, and from there back through the projector's lens.
  const Vec3 there = rig_from_far_ * Vec3(2 * 97.0 / 200, 1.6 * 66.0 / 160, 0);
  const auto on_wall = intersect(Ray{eye_, there - eye_}, Plane::of_xy(rig_from_wall_));
  ASSERT_TRUE(on_wall);
  const RigProjector& projector = rig_.projector("");
  const Vec2 expected = *projector.projector.project(projector.rig_from_projector.inverse() * *on_wall);
  const ImageU8 frame = io::load_image(folder_ / "frame.png").image;
  Vec2 sum = Vec2::Zero();
  double weight = 0;
  for (int y = 0; y < frame.height(); ++y)
    for (int x = 0; x < frame.width(); ++x) {
      if (frame.at(x, y, 1) < 128) continue;
      sum += Vec2(x, y);
      weight += 1;
    }
  ASSERT_GT(weight, 100);
  EXPECT_LT((sum / weight - expected).norm(), 0.3) << "px: a square's middle, by whole pixels";
  EXPECT_FALSE(io::load_image(folder_ / "seen.png").image.empty());
}

TEST_F(ViewerRoute, SaysWhatIsMissing) {
  const auto refused = [&](const std::string& more, const std::string& why) {
    const ToolRun run = render(more);
    EXPECT_NE(run.exit_code, 0);
    EXPECT_NE(run.err.find(why), std::string::npos) << run.err;
  };
  refused("--viewer=0.1m,0.2m,0.3m", "--virtual");
  refused("--virtual " + at("things.json"), "--viewer");
  refused("--viewer=0.1,0.2m,0.3m --virtual " + at("things.json"), "unit");
  refused("--viewer=0.1m,0.2m --virtual " + at("things.json"), "X,Y,Z");
  SurfaceSet pixels;
  PixelSurface shape;
  shape.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  shape.pixels = {{10, 10}, {90, 10}, {90, 70}, {10, 70}};
  Surface surface;
  surface.name = "dragged";
  surface.geometry = shape;
  pixels.surfaces = {surface};
  io::save_surfaces(folder_ / "pixels.json", pixels);
  refused("--viewer=0.1m,0.2m,0.3m --virtual " + at("pixels.json"), "dragged");
}

}  // namespace
}  // namespace procam::test
