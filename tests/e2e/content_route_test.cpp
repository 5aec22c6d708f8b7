/// render-to-image and export-warp with every kind of content, fits, outlines, videos and two projectors.
#include <gtest/gtest.h>

#include <cstring>

#include "e2e/tool_runner.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "support/numeric_world.hpp"

namespace procam::test {
namespace {

namespace fs = std::filesystem;

/// A wall of 1.2 m x 0.6 m before two projectors of one rig, placed in the rig.
class ContentRoute : public ::testing::Test {
 protected:
  void SetUp() override {
    const NumericWorld world;
    projector_ = world.projector;
    Rig rig;
    rig.cameras.push_back({"camera", world.camera, Pose()});
    rig.projectors.push_back({"left", world.projector, Pose()});
    rig.projectors.push_back(
        {"right", world.projector, Pose(so3_exp<double>(Vec3(0.01, -0.05, 0.02)), Vec3(0.35, 0.02, 0.1))});
    io::save_rig(folder_ / "rig.json", rig);
    PlanarSurface plane;
    plane.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    plane.points = {{0, 0}, {1.2, 0}, {1.2, 0.6}, {0, 0.6}};
    plane.frame = "rig";
    plane.frame_from_surface = in_rig_;
    wall_.name = "wall";
    wall_.geometry = plane;
    fs::create_directories(folder_ / "shots");
    for (int i = 0; i < 3; ++i)
      io::save_image(folder_ / "shots" / ("p" + std::to_string(i) + ".png"),
                     ImageU8(20, 20, 3, std::uint8_t(60 + 60 * i)));
  }

  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  void solve(const std::string& projector, const std::string& solved) const {
    SurfaceSet set;
    set.surfaces = {wall_};
    io::save_surfaces(folder_ / "surfaces.json", set);
    const ToolRun run =
        run_tool("solve-surfaces", "--rig " + at("rig.json") + " --surfaces " + at("surfaces.json") +
                                       " --projector " + projector + " -o " + at(solved));
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  ToolRun render(const std::string& more, const std::string& solved = "solved.json") const {
    return run_tool("render-to-image", "--rig " + at("rig.json") + " --surfaces " + at(solved) + " " + more);
  }
  /// What the left projector shows at a place of the wall.
  int shown(const std::string& frame, double u, double v, int channel = 0) const {
    const ImageU8 image = io::load_image(folder_ / frame).image;
    const Vec2 pixel = *projector_.project(in_rig_ * Vec3(1.2 * u, 0.6 * v, 0));
    return image.at(int(std::lround(pixel.x())), int(std::lround(pixel.y())), channel);
  }

  ScratchFolder folder_;
  Projector projector_;
  const Pose in_rig_ = Pose(so3_exp<double>(Vec3(0.05, 0.2, -0.03)), Vec3(-0.55, -0.85, 1.9));
  Surface wall_;
};

// Light as floats: what the .png's values stand for, before they are rounded.
TEST_F(ContentRoute, FramesOfLightAreExr) {
  solve("left", "solved.json");
  const std::string content = "--content wall=#804020 ";
  ASSERT_EQ(render(content + "-o " + at("values.png")).exit_code, 0);
  const ToolRun light = render(content + "-o " + at("light.exr") + " --preview " + at("seen.png"));
  ASSERT_EQ(light.exit_code, 0) << light.err;
  EXPECT_TRUE(fs::exists(folder_ / "seen.png"));
  const std::string file = slurp(folder_ / "light.exr");
  const ImageU8 values = io::load_image(folder_ / "values.png").image;
  EXPECT_EQ(values.at(values.width() / 2, values.height() / 2, 0), 0x80);
  // Uncompressed: the last row's blue, green and red planes end the file.
  const auto row = [&](int y, int plane, int x) {
    float number = 0;
    const std::size_t from_end = std::size_t(values.height() - y) * (8 + 12 * std::size_t(values.width())) -
                                 8 - 4 * (std::size_t(plane) * std::size_t(values.width()) + std::size_t(x));
    std::memcpy(&number, file.data() + file.size() - from_end, 4);
    return double(number);
  };
  const int x = values.width() / 2, y = values.height() / 2;
  EXPECT_NEAR(row(y, 2, x), 0.21586, 5e-5) << "red 0x80";
  EXPECT_NEAR(row(y, 0, x), 0.01444, 5e-5) << "blue 0x20";
  ASSERT_EQ(render(content + "--duration 0.1s --fps 20 -o " + at("l_%02d.exr")).exit_code, 0);
  EXPECT_TRUE(fs::exists(folder_ / "l_01.exr"));
  EXPECT_NE(render(content + "--duration 0.1s -o " + at("l.exr")).exit_code, 0);
  EXPECT_NE(render(content + "--gamma 2.2 -o " + at("l.exr")).exit_code, 0);
  EXPECT_NE(render(content + "--renderer gl -o " + at("l.exr")).exit_code, 0);
}

TEST_F(ContentRoute, SequencesBecomeFramesAndVideos) {
  solve("left", "solved.json");
  const std::string content = "--content wall=" + at("shots") + "/p%d.png@10 --duration 0.5s ";
  const ToolRun frames = render(content + "--fps 10 --time 100ms -o " + at("f_%02d.png") + " --json");
  ASSERT_EQ(frames.exit_code, 0) << frames.err;
  EXPECT_EQ(frames.json()["frames"], 5);
  for (int n = 0; n < 5; ++n)
    EXPECT_EQ(shown("f_0" + std::to_string(n) + ".png", 0.5, 0.5), 60 + 60 * ((n + 1) % 3));
  EXPECT_FALSE(fs::exists(folder_ / "f_05.png"));
  const ToolRun video = render(content + "--fps 10 -o " + at("out.mkv"));
  ASSERT_EQ(video.exit_code, 0) << video.err;
  // What was written is content as well.
  const ToolRun again = render("--content wall=" + at("out.mkv") + " --time 250ms -o " + at("again.png"));
  ASSERT_EQ(again.exit_code, 0) << again.err;
  const ToolRun refused = render(content + "-o " + at("out.webm"));
  EXPECT_EQ(refused.exit_code, 3);
  EXPECT_NE(refused.err.find("out.webm"), std::string::npos) << refused.err;
}

TEST_F(ContentRoute, FitCropOutlineAndMaskComeFromTheFileAndTheFlags) {
  wall_.content = "#c86432";
  wall_.layout.fit = Fit::kContain;
  wall_.shape.holes = {{{0.4, 0.4}, {0.6, 0.4}, {0.6, 0.6}, {0.4, 0.6}}};
  wall_.shape.mask_file = "mask.png";
  ImageU8 mask(40, 4, 1, 255);
  for (int y = 0; y < 4; ++y)
    for (int x = 28; x < 40; ++x) mask.at(x, y) = 0;  // from u = 0.7
  io::save_image(folder_ / "mask.png", mask);
  fs::create_directories(folder_ / "solved");
  solve("left", "solved/s.json");
  const std::string out = " -o " + at("frame.png");
  ToolRun run = render(out, "solved/s.json");  // a colour fills
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(shown("frame.png", 0.1, 0.5), 0xc8);
  EXPECT_EQ(shown("frame.png", 0.1, 0.5, 2), 0x32);
  EXPECT_EQ(shown("frame.png", 0.5, 0.5), 0) << "the hole";
  EXPECT_EQ(shown("frame.png", 0.8, 0.2), 0) << "the mask";
  const std::string square = "--content wall=" + at("shots/p1.png");  // of 2 : 1 the middle half
  run = render(square + out, "solved/s.json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(shown("frame.png", 0.1, 0.5), 0);
  EXPECT_EQ(shown("frame.png", 0.35, 0.5), 120);
  run = render(square + " --fit wall=cover --crop wall=0,0,1,0.5" + out, "solved/s.json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(shown("frame.png", 0.1, 0.5), 120);
  for (const auto& [more, words] : std::vector<std::pair<std::string, std::string>>{
           {"--fit wall=squeeze", "no such fit"},
           {"--crop wall=0,0,1", "LEFT,TOP,RIGHT,BOTTOM"},
           {"--crop wall=0.5,0,0.4,1", "LEFT,TOP,RIGHT,BOTTOM"},
           {"--fit floor=cover", "name one of: wall"},
           {"--content wall=#12345", "colour"},
           {"--content wall=camera:93", "camera 93"},
           {"--content wall=" + at("nothing.mp4"), "no such file"},
           {"--brightness left=2", "--compensate"}}) {
    run = render(more + " -o " + at("refused.png"), "solved/s.json");
    EXPECT_NE(run.exit_code, 0) << more;
    EXPECT_NE(run.err.find(words), std::string::npos) << run.err;
    EXPECT_FALSE(fs::exists(folder_ / "refused.png")) << more;
  }
}

TEST_F(ContentRoute, TwoProjectorsShareTheWall) {
  wall_.content = "#ffffff";
  solve("left", "solved.json");
  solve("right", "right.json");
  const std::string blend =
      " --black left=0.002 --black right=0.003 --compensate 0.2 --brightness right=1.3 ";
  ToolRun run = render("--blend-with " + at("right.json") + blend + "-o " + at("l.png") + " --weights " +
                       at("l_w.png"));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  run = render(
      "--blend-with " + at("solved.json") + blend + "-o " + at("r.png") + " --weights " + at("r_w.png"),
      "right.json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const ImageU8 left = io::load_image(folder_ / "l_w.png").image,
                right = io::load_image(folder_ / "r_w.png").image;
  const auto range = [](const ImageU8& image) {
    const auto ends = std::minmax_element(image.data(), image.data() + image.width() * image.height());
    return std::pair<int, int>(*ends.first, *ends.second);
  };
  EXPECT_EQ(range(left), std::pair(0, 255));
  EXPECT_EQ(range(right), std::pair(0, 255));
  // Who looks at the wall sees both: no step, and no fall where one hands over to the other.
  const auto wall_seen = [&](const std::string& with) {
    const ToolRun seen = render(with + "-o " + at("l.png") + " --preview " + at("seen.png"));
    EXPECT_EQ(seen.exit_code, 0) << seen.err;
    const ImageU8 view = io::load_image(folder_ / "seen.png").image;
    std::pair<int, int> ends(255, 0);
    for (int x = view.width() / 5; x < view.width() * 4 / 5;
         ++x) {  // the wall, of a picture 1.4 times as wide
      const int value = view.at(x, view.height() / 2, 1);
      ends = {std::min(ends.first, value), std::max(ends.second, value)};
    }
    return ends;
  };
  const auto both = wall_seen("--blend-with " + at("right.json") + blend), alone = wall_seen("");
  EXPECT_GT(both.first, both.second - 12);
  EXPECT_LT(alone.first, 100) << "of " << alone.second;
  run = run_tool("export-warp", "--rig " + at("rig.json") + " --surfaces " + at("solved.json") +
                                    " --blend-with " + at("right.json") + " -o " + at("wall.png"));
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("--blend"), std::string::npos) << run.err;
  run = render("--blend-with " + at("solved.json") + " -o " + at("twice.png"));
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("solved for 'left'"), std::string::npos) << run.err;
}

}  // namespace
}  // namespace procam::test
