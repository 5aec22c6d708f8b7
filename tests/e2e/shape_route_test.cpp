/// A live shape as a user starts it: depth images of simulated sand in a folder, and the frames that the tool writes.
#include <gtest/gtest.h>

#include "procam/io/image/depth_file.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/rig_file.hpp"
#include "running_tool.hpp"
#include "support/sand.hpp"

namespace procam::test {
namespace {

class ShapeRoute : public testing::Test {
 protected:
  void SetUp() override {
    Rig rig;
    RigProjector lamp;
    lamp.name = "lamp";
    lamp.projector.inverse_camera = {{480, 300}, {505, 498, 235.3, 161.9, 0.7}, NoDistortion{}};
    lamp.rig_from_projector = Pose(so3_exp(Vec3(0.04, -0.17, 0.03)), Vec3(0.19, -0.05, 0.04));
    rig.projectors.push_back(lamp);
    for (const char* name : {"depth", "eye"}) {
      RigCamera camera;
      camera.name = name;
      camera.camera = box_.sensor.camera;
      rig.cameras.push_back(camera);
    }
    io::save_rig(folder_ / "rig.json", rig);
    rig.cameras.pop_back();
    io::save_rig(folder_ / "one.json", rig);
    fs::create_directory(folder_ / "depth");
  }
  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  void write_sand(int images) {
    for (int i = 0; i < images; ++i)
      io::save_depth(folder_ / "depth" / (std::to_string(1000 + i) + ".png"),
                     box_.seen(box_.room(0.2 * i / 30.0, 0), std::uint64_t(i + 1)).view());
  }
  ToolRun show(const std::string& surfaces, const std::string& more = "") {
    return run_tool("project-live",
                    "--rig " + at("rig.json") + " --depth-camera depth --surfaces '" + surfaces +
                        "' --delay 20ms --depth-delay 5ms --control off --json --threads 1 --fps 15 " +
                        "--duration 2.4s --output frames:" + at("frames") + " " + more);
  }
  /// Of the pixels of the frame with most light (on a busy machine the last one may lack it), those with light, and how many are very blue, very yellow or black lines between them.
  struct Light {
    int lit = 0, low = 0, high = 0;
  };
  Light fullest_light() const {
    Light fullest;
    for (const auto& entry : fs::directory_iterator(at("frames"))) {
      const Light light = light_of(entry.path());
      if (light.lit > fullest.lit) fullest = light;
    }
    return fullest;
  }
  Light light_of(const fs::path& file) const {
    const ImageU8 frame = io::load_image(file).image;
    Light light;
    for (int y = 0; y < frame.height(); ++y)
      for (int x = 0; x < frame.width(); ++x) {
        light.lit += frame.at(x, y, 0) + frame.at(x, y, 1) + frame.at(x, y, 2) > 0;
        light.low += frame.at(x, y, 2) > frame.at(x, y, 0) + 60;
        light.high += frame.at(x, y, 0) > frame.at(x, y, 2) + 60;
      }
    return light;
  }

  ScratchFolder folder_;
  SandBox box_{1};
};

TEST_F(ShapeRoute, SandGetsItsColoursByHeight) {
  write_sand(20);
  const ToolRun run = show("depth-shape:folder:" + at("depth") + "@30",
                           "--content shape=height:colours,range=-60mm..60mm,contours=15mm");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("sees shape"), std::string::npos) << run.err;
  const Light light = fullest_light();
  EXPECT_GT(light.lit, 480 * 300 / 3) << run.err << run.out;
  EXPECT_GT(light.low, 2000);
  EXPECT_GT(light.high, 2000);
}

TEST_F(ShapeRoute, ARegionHoldsTheLightAndAnyContentMayLieOnIt) {
  write_sand(20);
  const ToolRun run =
      show("depth-shape:folder:" + at("depth") + "@30,region=240:180:160x120", "--content shape=#ffffff");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Light light = fullest_light();
  EXPECT_GT(light.lit, 2000);
  EXPECT_LT(light.lit, 480 * 300 / 8);
  EXPECT_EQ(light.low + light.high, 0);
}

TEST_F(ShapeRoute, WhatCannotBeIsRefusedWithItsReason) {
  write_sand(2);
  const std::string source = "depth-shape:folder:" + at("depth");
  const auto refuses = [&](const std::string& surfaces, const std::string& more, int code,
                           const std::string& why) {
    const ToolRun run = show(surfaces, more);
    EXPECT_EQ(run.exit_code, code) << run.err;
    EXPECT_NE(run.err.find(why), std::string::npos) << run.err;
  };
  refuses(source + ",region=500:100:200x100", "", 3, "not inside of the 640x480 pixels of camera 'depth'");
  refuses(source + ",region=big", "", 3, "it does not read X:Y:WIDTHxHEIGHT");
  refuses("depth-shape:folder:" + at("nowhere"), "", 6, "nowhere");
  refuses("depth-shape:magic", "", 3, "magic");
  refuses(source, "--content shape=height:grey", 3, "it does not begin with height:colours");
  refuses("depth:folder:" + at("depth"), "--content wall_1=height:colours", 3, "there is no live shape");
  refuses(source, "--record " + at("run.log"), 3, "a live shape cannot be shown again");
  const ToolRun unknown =
      run_tool("project-live", "--rig " + at("rig.json") + " --depth-camera other --surfaces " + source);
  EXPECT_EQ(unknown.exit_code, 3);
  EXPECT_NE(unknown.err.find("other"), std::string::npos) << unknown.err;
}

TEST_F(ShapeRoute, AnEmptyViewIsReportedAndTheShowGoesOn) {
  for (int i = 0; i < 4; ++i)
    io::save_depth(folder_ / "depth" / (std::to_string(1000 + i) + ".png"),
                   Image<std::uint16_t>(640, 480).view());
  const ToolRun run = show("depth-shape:folder:" + at("depth") + "@30", "--content shape=#ffffff");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("the depth camera has readings in 0 of"), std::string::npos) << run.err;
  EXPECT_EQ(fullest_light().lit, 0);
}

#ifdef PROCAM_SANDBOX
TEST_F(ShapeRoute, TheSandboxExampleShowsHeights) {
  write_sand(20);
  // On a busy machine the first shape takes seconds, and the light ends after the last image.
  std::string said;
  int most = 0;
  for (const char* duration_s : {"0.6", "6"}) {
    const ToolRun run = run_program(PROCAM_SANDBOX, at("one.json") + " folder:" + at("depth") +
                                                        "@30 frames:" + at("frames") + " " + duration_s);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    said = run.out;
    for (const auto& entry : fs::directory_iterator(at("frames")))
      most = std::max(most, light_of(entry.path()).low);
    if (most > 1000) break;
  }
  EXPECT_NE(said.find("sees shape"), std::string::npos) << said;
  EXPECT_GT(most, 1000);
}
#endif

}  // namespace
}  // namespace procam::test
