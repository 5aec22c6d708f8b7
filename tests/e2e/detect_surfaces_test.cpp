/// detect-surfaces as a person runs it: a simulated depth image to surfaces that solve-surfaces takes, and
/// bad images refused in three parts.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "e2e/tool_runner.hpp"
#include "procam/io/image/depth_file.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/image/pfm.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/simulate/depth_view.hpp"

namespace procam::test {
namespace {

namespace fs = std::filesystem;

class DetectSurfaces : public ::testing::Test {
 protected:
  void SetUp() override {
    simulate::Room room;
    const auto plane = [&](const std::string& name, const Vec3& turn, const Vec3& at, const Vec2& size) {
      room.bodies.push_back(
          {name, simulate::Rectangle{-0.5 * size, 0.5 * size}, Pose(so3_exp(turn), at), 0.5});
    };
    plane("wall", Vec3(0, 0.1, 0), Vec3(0, 0, 2), Vec2(3, 2.4));
    plane("floor", Vec3(-kPi / 2, 0, 0), Vec3(0, 0.6, 1.5), Vec2(3, 2));
    simulate::DepthSensor sensor;
    depth_ = simulate::depth_view(room, sensor, Pose(), 3).mm;
    io::save_depth(folder_ / "depth.png", depth_);
  }
  ToolRun run(const std::string& depth, const std::string& more = "") const {
    return run_tool("detect-surfaces", "--json --depth " + at(depth) + " --gravity 0,1,0 -o " +
                                           at("out.json") + " --preview " + at("seen.png") + " " + more);
  }
  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  void expect_refused(const ToolRun& run, int exit_code, const std::string& why) const {
    EXPECT_EQ(run.exit_code, exit_code) << run.err;
    for (const std::string& part : std::vector<std::string>{"why:", why, "next:"})
      EXPECT_NE(run.err.find(part), std::string::npos) << "no '" << part << "' in: " << run.err;
    EXPECT_FALSE(fs::exists(folder_ / "out.json"));
  }

  ScratchFolder folder_;
  Image<std::uint16_t> depth_;
  const std::string camera_ = "--intrinsics 585,585,319.5,239.5";
};

TEST_F(DetectSurfaces, WritesNamedSurfacesAndAPreview) {
  const ToolRun found = run("depth.png", camera_);
  ASSERT_EQ(found.exit_code, 0) << found.err;
  const SurfaceSet set = io::load_surfaces(folder_ / "out.json");
  ASSERT_EQ(set.surfaces.size(), 2u);
  EXPECT_EQ(set.surfaces[0].name, "wall_1");
  EXPECT_EQ(set.surfaces[1].name, "floor");
  const auto& wall = std::get<PlanarSurface>(set.surfaces[0].geometry);
  EXPECT_EQ(wall.frame, "rig");
  const Vec3 into = wall.frame_from_surface.rotate(Vec3::UnitZ());
  EXPECT_NEAR(into.x(), std::sin(0.1), 1e-3);
  EXPECT_EQ(found.json()["surfaces"][0]["kind"], "wall");
  const ImageU8 preview = io::load_image(folder_ / "seen.png").image;
  EXPECT_GT(preview.width(), 1280);  // the image at twice its size, and a legend
  EXPECT_GE(preview.height(), 960);
}

TEST_F(DetectSurfaces, ListsEveryPlaneWithItsState) {
  simulate::Room room;
  const auto plane = [&](const std::string& name, const Vec3& at, const Vec2& size) {
    room.bodies.push_back(
        {name, simulate::Rectangle{-0.5 * size, 0.5 * size}, Pose(Eigen::Quaterniond::Identity(), at), 0.5});
  };
  plane("wall", Vec3(0, 0, 2.5), Vec2(3.4, 2.6));
  plane("board", Vec3(0.1, 0.3, 1.6), Vec2(1.3, 0.17));  // narrower than any content
  const simulate::DepthSensor sensor;
  io::save_depth(folder_ / "board.png", simulate::depth_view(room, sensor, Pose(), 3).mm);
  const ToolRun found = run("board.png", camera_);
  ASSERT_EQ(found.exit_code, 0) << found.err;
  const auto json = found.json();
  ASSERT_EQ(json["surfaces"].size(), 1u);
  EXPECT_EQ(json["surfaces"][0]["state"], "free");
  ASSERT_EQ(json["planes"].size(), 2u);
  EXPECT_EQ(json["planes"][0]["state"], "free");
  EXPECT_EQ(json["planes"][0]["surface"], "wall_1");
  EXPECT_EQ(json["planes"][1]["state"], "no_free_rectangle");
  EXPECT_FALSE(json["planes"][1].contains("surface"));
  EXPECT_NEAR(json["planes"][1]["offset"].get<double>(), 1.6, 0.01);
  EXPECT_NEAR(json["planes"][1]["area"].get<double>(), 1.3 * 0.17, 0.05);
}

TEST_F(DetectSurfaces, NamesTheSensorThatTheNoiseFits) {
  const ToolRun own = run("depth.png", camera_);
  ASSERT_EQ(own.exit_code, 0) << own.err;
  EXPECT_TRUE(own.json()["sensor"]["fits"].get<bool>());
  EXPECT_EQ(own.err.find("sensor"), std::string::npos) << own.err;
  const ToolRun other = run("depth.png", camera_ + " --sensor-model tof");
  ASSERT_EQ(other.exit_code, 0) << other.err;
  EXPECT_FALSE(other.json()["sensor"]["fits"].get<bool>());
  EXPECT_NE(other.err.find("give --sensor-model kinect-v1"), std::string::npos) << other.err;
  // And its planes are found all the same.
  EXPECT_EQ(other.json()["surfaces"].size(), 2u);
}

TEST_F(DetectSurfaces, TakesFloatsInMetres) {
  ImageF metres(640, 480);
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x)
      metres.at(x, y) = depth_.at(x, y) > 0 ? 1e-3f * float(depth_.at(x, y)) : std::nanf("");
  io::save_pfm(folder_ / "depth.pfm", metres.view());
  ASSERT_EQ(run("depth.png", camera_).exit_code, 0);
  const SurfaceSet from_units = io::load_surfaces(folder_ / "out.json");
  const ToolRun found = run("depth.pfm", camera_);
  ASSERT_EQ(found.exit_code, 0) << found.err;
  const SurfaceSet from_metres = io::load_surfaces(folder_ / "out.json");
  ASSERT_EQ(from_metres.surfaces.size(), from_units.surfaces.size());
  for (std::size_t i = 0; i < from_units.surfaces.size(); ++i) {
    const auto& a = std::get<PlanarSurface>(from_units.surfaces[i].geometry).frame_from_surface;
    const auto& b = std::get<PlanarSurface>(from_metres.surfaces[i].geometry).frame_from_surface;
    EXPECT_LT((a.translation - b.translation).norm(), 1e-3);
  }
  fs::remove(folder_ / "out.json");
  expect_refused(run("depth.pfm", camera_ + " --scale sun"), 3, "nothing is packed");
}

TEST_F(DetectSurfaces, RefusesBadDepthInThreeParts) {
  expect_refused(run("depth.png", camera_ + " --scale 1m"), 2, "cannot be that long");
  expect_refused(run("depth.png", camera_ + " --scale 0.01mm"), 3, "median depth");
  expect_refused(run("depth.png", camera_ + " --scale 1"), 2, "the unit is missing");
  expect_refused(run("depth.png", "--intrinsics 0,585,319.5,239.5"), 3, "not positive");
  expect_refused(run("depth.png", "--intrinsics 585,585,319.5"), 3, "these are 3 numbers");
  expect_refused(run("depth.png", "--intrinsics 585,319.5,585,2390"), 3, "far outside the image");
  expect_refused(run("depth.png", "--rig " + std::string(PROCAM_E2E_SESSION) + "/truth.json"), 3, "640x480");
  expect_refused(run("absent.png", camera_), 3, "absent.png");

  io::save_depth(folder_ / "zero.png", Image<std::uint16_t>(640, 480));
  expect_refused(run("zero.png", camera_), 4, "all are zero");
  io::save_image(folder_ / "eight.png", ImageU8(640, 480, 1, 100));
  expect_refused(run("eight.png", camera_), 3, "not 16 bits");
  const std::string bytes = slurp(folder_ / "depth.png");
  std::ofstream(folder_ / "cut.png", std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  expect_refused(run("cut.png", camera_), 3, "cut");
  Image<std::uint16_t> noise(640, 480);
  unsigned state = 1;
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x) {
      state = state * 1664525u + 1013904223u;
      noise.at(x, y) = std::uint16_t(500 + (state >> 16) % 4000);
    }
  io::save_depth(folder_ / "noise.png", noise);
  expect_refused(run("noise.png", camera_), 4, "times the noise of --sensor-model kinect-v1");
}

TEST_F(DetectSurfaces, PlacesThemInTheWorldByAPose) {
  std::ofstream(at("pose.json"))
      << R"({"format": "procam-pose", "version": 1, "target": "world", "source": "rig",
    "translation": [0.5, -1, 2], "rotation_xyzw": [0, 0, 0.7071067811865476, 0.7071067811865476]})";
  const ToolRun in_rig = run("depth.png", camera_);
  ASSERT_EQ(in_rig.exit_code, 0) << in_rig.err;
  const SurfaceSet before = io::load_surfaces(folder_ / "out.json");
  const ToolRun in_world = run("depth.png", camera_ + " --pose " + at("pose.json"));
  ASSERT_EQ(in_world.exit_code, 0) << in_world.err;
  const SurfaceSet after = io::load_surfaces(folder_ / "out.json");
  const auto &rig = std::get<PlanarSurface>(before.surfaces[0].geometry),
             &world = std::get<PlanarSurface>(after.surfaces[0].geometry);
  EXPECT_EQ(world.frame, "world");
  const Pose world_from_rig(so3_exp(Vec3(0, 0, kPi / 2)), Vec3(0.5, -1, 2));
  EXPECT_LT(
      (world.frame_from_surface.translation - world_from_rig * rig.frame_from_surface.translation).norm(),
      1e-9);
}

TEST_F(DetectSurfaces, UnpacksWhatOtherProgramsPacked) {
  Image<std::uint16_t> sun = depth_, nyu = depth_;
  for (int y = 0; y < depth_.height(); ++y)
    for (int x = 0; x < depth_.width(); ++x) {
      const int mm = depth_.at(x, y);
      sun.at(x, y) = std::uint16_t(mm << 3 | mm >> 13);
      nyu.at(x, y) = mm > 0 ? std::uint16_t(std::lround(1092.5 - 351300.0 / mm)) : std::uint16_t(2047);
    }
  io::save_depth(folder_ / "sun.png", sun);
  io::save_depth(folder_ / "nyu.png", nyu);
  for (const std::string name : {"sun", "nyu"}) {
    const ToolRun found = run(name + ".png", camera_ + " --scale " + name);
    ASSERT_EQ(found.exit_code, 0) << found.err;
    const SurfaceSet set = io::load_surfaces(folder_ / "out.json");
    ASSERT_EQ(set.surfaces.size(), 2u) << name;
    const auto& wall = std::get<PlanarSurface>(set.surfaces[0].geometry);
    EXPECT_NEAR(wall.frame_from_surface.rotate(Vec3::UnitZ()).x(), std::sin(0.1), 5e-3) << name;
  }
}

}  // namespace
}  // namespace procam::test
