/// solve-surfaces and render-to-image as programs: from a rig and surfaces to a frame, and what they refuse.
#include <gtest/gtest.h>

#include <fstream>

#include "e2e/tool_runner.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "support/numeric_world.hpp"

namespace procam::test {
namespace {

namespace fs = std::filesystem;

/// A sheet on a wall 1.6 m away, turned by 47 degrees, placed in the world; the projector's pose is a file.
class DrawRoute : public ::testing::Test {
 protected:
  void SetUp() override {
    const NumericWorld world;
    Rig rig;
    rig.cameras.push_back({"camera", world.camera, Pose()});
    rig.projectors.push_back({"projector", world.projector, world.projector_from_camera.inverse()});
    io::save_rig(folder_ / "rig.json", rig);

    const Pose projector_from_sheet(so3_exp<double>(Vec3(0.05, 47 * kDegree, -0.03)),
                                    Vec3(-0.07, -0.45, 1.6));
    const Pose projector_from_world(so3_exp<double>(Vec3(-0.2, 0.3, 0.1)), Vec3(0.4, -0.2, 0.3));
    io::save_pose(folder_ / "pose.json", {"projector", "world", {projector_from_world, Mat6::Zero()}});

    Surface sheet;
    sheet.name = "wall";
    PlanarSurface plane;
    plane.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0.5, 0.25}};
    plane.points = {{0, 0}, {0.202, 0}, {0.202, 0.211}, {0, 0.211}, {0.101, 0.05275}};
    plane.frame_from_surface = projector_from_world.inverse() * projector_from_sheet;
    sheet.geometry = plane;
    surfaces_.surfaces = {sheet};
    io::save_surfaces(folder_ / "surfaces.json", surfaces_);
    io::save_surfaces(folder_ / "surfaces.xml", surfaces_);

    ImageU8 picture(90, 94, 3, 40);
    for (int y = 20; y < 60; ++y)
      for (int x = 10; x < 70; ++x) picture.at(x, y, 1) = 220;
    io::save_image(folder_ / "picture.png", picture);
  }

  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  ToolRun solve(const std::string& surfaces, const std::string& solved, const std::string& more = "") {
    return run_tool("solve-surfaces", "--rig " + at("rig.json") + " --surfaces " + at(surfaces) + " -o " +
                                          at(solved) + " " + more);
  }
  ToolRun render(const std::string& solved, const std::string& frame, const std::string& content) {
    return run_tool("render-to-image", "--rig " + at("rig.json") + " --surfaces " + at(solved) +
                                           " --content " + content + " -o " + at(frame));
  }

  ScratchFolder folder_;
  SurfaceSet surfaces_;
};

TEST_F(DrawRoute, OpenGlDrawsTheFrameThatTheCpuDraws) {
  ASSERT_EQ(solve("surfaces.json", "solved.json", "--pose " + at("pose.json")).exit_code, 0);
  const std::string content = "wall=" + at("picture.png");
  ASSERT_EQ(render("solved.json", "cpu.png", content).exit_code, 0);
  const ToolRun drawn = render("solved.json", "gl.png", content + " --renderer gl");
  if (drawn.exit_code != 0) {  // refused in three parts, and nothing written
    EXPECT_NE(drawn.err.find("draw on the CPU"), std::string::npos) << drawn.err;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "gl.png"));
    GTEST_SKIP() << drawn.err;
  }
  const ImageU8 cpu = io::load_image(folder_ / "cpu.png").image,
                gl = io::load_image(folder_ / "gl.png").image;
  ASSERT_EQ(cpu.size(), gl.size());
  int apart = 0, lit = 0;
  for (int y = 0; y < cpu.height(); ++y)
    for (int x = 0; x < cpu.width(); ++x) {
      apart += std::abs(cpu.at(x, y, 1) - gl.at(x, y, 1)) > 2;
      lit += cpu.at(x, y, 1) > 100;
    }
  EXPECT_GT(lit, 1000);
  EXPECT_LE(apart, 1e-3 * cpu.width() * cpu.height());
}

TEST_F(DrawRoute, JsonAndXmlGiveTheSameFrame) {
  const std::string pose = "--pose " + at("pose.json");
  for (const std::string syntax : {"json", "xml"}) {
    const ToolRun solved = solve("surfaces." + syntax, "solved." + syntax, pose + " --json");
    ASSERT_EQ(solved.exit_code, 0) << solved.err;
    EXPECT_NO_THROW(solved.json());
    const ToolRun drawn = render("solved." + syntax, syntax + ".png", "wall=" + at("picture.png"));
    ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  }
  const std::string frame = slurp(folder_ / "json.png");
  EXPECT_EQ(frame, slurp(folder_ / "xml.png"));
  const ImageU8 image = io::load_image(folder_ / "json.png").image;
  EXPECT_EQ(image.size(), (ImageSize{1024, 768}));
  int lit = 0;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) lit += image.at(x, y, 1) > 200;
  EXPECT_GT(lit, 2000);
}

TEST_F(DrawRoute, DrawsCurvedSurfacesAndMeshesFromTheirDefinitions) {
  // A column and, half hidden by it, a mesh in mm; the solved file lies in another folder than they do.
  CylinderSurface column;
  column.frame = "projector";
  column.radius = 0.12;
  column.top = -0.1;
  column.bottom = 0.15;
  column.frame_from_surface = Pose(so3_exp<double>(Vec3(0.1, 0.2, 0)), Vec3(-0.1, -0.4, 1.6));
  MeshSurface tent;
  tent.frame = "projector";
  tent.file = "shapes/tent.obj";
  tent.metres_per_unit = 0.001;
  tent.frame_from_surface = Pose(so3_exp<double>(Vec3(0, 0, 0.1)), Vec3(-0.1, -0.5, 1.9));
  fs::create_directories(folder_ / "shapes");
  fs::create_directories(folder_ / "solved");
  std::ofstream(folder_ / "shapes/tent.obj")
      << "v 0 0 100\nv 150 10 0\nv 300 0 90\nv 0 250 100\nv 150 260 0\nv 300 250 90\n"
         "vt 0 1\nvt 0.5 1\nvt 1 1\nvt 0 0\nvt 0.5 0\nvt 1 0\nf 1/1 2/2 5/5 4/4\nf 2/2 3/3 6/6 5/5\n";
  SurfaceSet set;
  set.surfaces = {{"column", column, {}, "picture.png"}, {"tent", tent, {}, "picture.png"}};
  io::save_surfaces(folder_ / "shapes.json", set);

  const ToolRun solved = solve("shapes.json", "solved/shapes.json", "--json");
  ASSERT_EQ(solved.exit_code, 0) << solved.err;
  EXPECT_NE(solved.err.find("column"), std::string::npos) << solved.err;
  EXPECT_LT(double(solved.json()["surfaces"][0]["incidence_deg"]), 40);
  EXPECT_EQ(solved.json()["surfaces"][1].count("rms_mm"), 0u) << "nothing was fitted";
  const ToolRun drawn =
      run_tool("render-to-image", "--rig " + at("rig.json") + " --surfaces " + at("solved/shapes.json") +
                                      " -o " + at("shapes.png") + " --preview " + at("seen.png"));
  ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  const ImageU8 seen = io::load_image(folder_ / "seen.png").image;
  int lit = 0, dark = 0;  // no surface of these is flat, and still there is somebody who looks at them
  for (int y = 0; y < seen.height(); ++y)
    for (int x = 0; x < seen.width(); ++x) {
      lit += seen.at(x, y, 1) > 120 && seen.at(x, y, 0) < 100;
      dark += seen.at(x, y, 1) < 80;
    }
  EXPECT_GT(lit, seen.width() * seen.height() / 20);
  EXPECT_GT(dark, seen.width() * seen.height() / 20);

  // The picture is green where 10 <= x < 70 of 90 and 20 <= y < 60 of 94, dark grey elsewhere.
  const ImageU8 frame = io::load_image(folder_ / "shapes.png").image;
  const Projector projector = NumericWorld().projector;
  const auto green_at = [&](const Vec3& in_projector) {
    const Vec2 pixel = *projector.project(in_projector);
    return int(frame.at(int(std::lround(pixel.x())), int(std::lround(pixel.y())), 1));
  };
  for (const auto& [u, v, green] :
       {std::tuple{0.3, 0.4, 220}, {0.6, 0.55, 220}, {0.05, 0.5, 40}, {0.5, 0.75, 40}})
    EXPECT_EQ(green_at(column.frame_from_surface * column.point({u, v})), green) << u << " " << v;
  EXPECT_EQ(green_at(tent.frame_from_surface * Vec3(0.2, 0.14, 0.03)), 220) << "beside the column";
  EXPECT_EQ(green_at(tent.frame_from_surface * Vec3(0.28, 0.14, 0.078)), 40);
}

TEST_F(DrawRoute, RefusesAMeshWithoutTextureCoordinates) {
  MeshSurface tent;
  tent.frame = "projector";
  tent.file = "tent.obj";
  SurfaceSet set;
  set.surfaces = {{"tent", tent, {}, "picture.png"}};
  io::save_surfaces(folder_ / "shapes.json", set);
  std::ofstream(folder_ / "tent.obj") << "v 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\n";
  const ToolRun run = solve("shapes.json", "solved.json");
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_NE(run.err.find("tent.obj:4"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("texture coordinates"), std::string::npos) << run.err;
  EXPECT_FALSE(fs::exists(folder_ / "solved.json"));
}

TEST_F(DrawRoute, AsksForThePoseOfTheWorld) {
  const ToolRun run = solve("surfaces.json", "solved.json");
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("--pose"), std::string::npos) << run.err;
  EXPECT_FALSE(fs::exists(folder_ / "solved.json"));
}

TEST_F(DrawRoute, RefusesThreeCollinearOfFourNamingTheSurface) {
  auto& plane = std::get<PlanarSurface>(surfaces_.surfaces[0].geometry);
  plane.content = {{0, 0}, {0.5, 0}, {1, 0}, {0, 1}};
  plane.points = {{0, 0}, {0.1, 0}, {0.2, 0}, {0, 0.2}};
  io::save_surfaces(folder_ / "line.json", surfaces_);
  const ToolRun run = solve("line.json", "solved.json", "--pose " + at("pose.json"));
  EXPECT_EQ(run.exit_code, 4) << run.err;
  EXPECT_NE(run.err.find("wall"), std::string::npos) << run.err;
  EXPECT_NE(run.err.find("line"), std::string::npos) << run.err;
  EXPECT_FALSE(fs::exists(folder_ / "solved.json"));
}

TEST_F(DrawRoute, RefusesContentForASurfaceThatIsNotThere) {
  ASSERT_EQ(solve("surfaces.json", "solved.json", "--pose " + at("pose.json")).exit_code, 0);
  const ToolRun run = render("solved.json", "frame.png", "floor=" + at("picture.png"));
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("floor"), std::string::npos) << run.err;
  EXPECT_FALSE(fs::exists(folder_ / "frame.png"));
}

// A long video is not drawn for nothing.
TEST_F(DrawRoute, RefusesWhatItCouldNotWriteInTheEndBeforeItDraws) {
  ASSERT_EQ(solve("surfaces.json", "solved.json", "--pose " + at("pose.json")).exit_code, 0);
  for (const std::string& more : {" --preview " + at("view.jpg"), " --preview " + at("nowhere/view.png"),
                                  " --weights " + at("weights.txt")}) {
    const ToolRun run = render("solved.json", "frame.png", "wall=" + at("picture.png") + more);
    EXPECT_EQ(run.exit_code, 3) << more;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "frame.png")) << more;
  }
}

TEST_F(DrawRoute, RefusesADamagedPicture) {
  ASSERT_EQ(solve("surfaces.json", "solved.json", "--pose " + at("pose.json")).exit_code, 0);
  const std::string bytes = slurp(folder_ / "picture.png");
  std::ofstream(folder_ / "cut.png", std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  const ToolRun run = render("solved.json", "frame.png", "wall=" + at("cut.png"));
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("cut.png"), std::string::npos) << run.err;
  EXPECT_FALSE(fs::exists(folder_ / "frame.png"));
}

TEST_F(DrawRoute, PredictsTheErrorAndItsCause) {
  const std::string call = "--rig " + at("rig.json") + " --surfaces " + at("surfaces.json") + " --pose " +
                           at("pose.json") + " --map-sigma 2mm ";
  const ToolRun run = run_tool("predict-error", call +
                                                    "--pose-sigma 10mm,0.5deg --speed 0.5m/s,30deg/s --delay "
                                                    "50ms --monte-carlo 4000 --json --report " +
                                                    at("p.html"));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto wall = run.json()["surfaces"][0];
  // 30 deg/s for 50 ms turn the light by 26 mrad: at 1.6 m and 47 degrees some 40 to 60 mm.
  EXPECT_EQ(wall["causes"][0]["name"], "delay");
  EXPECT_GT(wall["rms_mm"], 40);
  EXPECT_LT(wall["rms_mm"], 90);
  EXPECT_NEAR(double(wall["monte_carlo_rms_mm"]) / double(wall["rms_mm"]), 1, 0.06);
  EXPECT_NE(run.err.find("carries no covariance"), std::string::npos);
  EXPECT_NE(slurp(folder_ / "p.html").find("</html>"), std::string::npos);

  for (const auto& [more, code, words] : std::vector<std::tuple<std::string, int, std::string>>{
           {"--pose-sigma -10mm", 2, "negative"},
           {"--pose-sigma 10", 2, "the unit is missing"},
           {"--speed 0.5m", 2, "does not end with '/s'"},
           {"--delay -5ms", 2, "negative"},
           {"--forward 0,0,0", 2, "not three numbers"},
           {"--report " + at("no/where.html"), 3, "no/where.html"}}) {
    const ToolRun refused = run_tool("predict-error", call + more);
    EXPECT_EQ(refused.exit_code, code) << more;
    EXPECT_NE(refused.err.find(words), std::string::npos) << refused.err;
  }
  const ToolRun no_pose =
      run_tool("predict-error", "--rig " + at("rig.json") + " --surfaces " + at("surfaces.json"));
  EXPECT_EQ(no_pose.exit_code, 3) << no_pose.err;
}

TEST_F(DrawRoute, DrawsOfSeveralProcessesAreJoined) {
  const std::string inputs =
      "--rig " + at("rig.json") + " --surfaces " + at("surfaces.json") + " --pose " + at("pose.json");
  const std::string call = inputs + " --map-sigma 2mm --pose-sigma 10mm,0.5deg --json ";
  const auto part = [&](const std::string& shard) { return at("draws_" + shard.substr(0, 1) + ".json"); };
  const ToolRun whole = run_tool("predict-error", call + "--monte-carlo 9000 --seed 5");
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  for (const std::string shard : {"1/3", "2/3", "3/3"}) {
    const ToolRun run = run_tool("predict-error", call + "--monte-carlo 9000 --seed 5 --shard " + shard +
                                                      " --save-draws " + part(shard));
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_NE(run.json()["surfaces"][0]["monte_carlo_rms_mm"],
              whole.json()["surfaces"][0]["monte_carlo_rms_mm"]);
  }
  const std::string all = " --draws " + part("1") + " " + part("2") + " " + part("3");
  const ToolRun joined = run_tool("predict-error", call + all);
  ASSERT_EQ(joined.exit_code, 0) << joined.err;
  EXPECT_NEAR(double(joined.json()["surfaces"][0]["monte_carlo_rms_mm"]),
              double(whole.json()["surfaces"][0]["monte_carlo_rms_mm"]), 1e-9);

  std::ofstream(folder_ / "cut.json") << slurp(folder_ / "draws_2.json").substr(0, 700);
  for (const auto& [more, code, words] : std::vector<std::tuple<std::string, int, std::string>>{
           {call + " --draws " + part("1") + " " + part("3"), 3, "it is one of 3 parts, and 2 are given"},
           {call + " --draws " + part("1") + " " + part("2") + " " + part("2"), 3, "it is the same part as"},
           {call + " --draws " + part("1") + " " + at("cut.json") + " " + part("3"), 3, "it is damaged"},
           {call + " --draws " + at("rig.json"), 3, "it is not a file of predict-error --save-draws"},
           {inputs + " --map-sigma 3mm" + all, 3,
            "was predicted from another rig, pose, surface or uncertainty"},
           {call + "--monte-carlo 4000 --shard 3/3 --save-draws " + at("new.json"), 3,
            "fewer than 2048 draws"},
           {call + "--monte-carlo 9000 --shard 4/3 --save-draws " + at("new.json"), 2, "it is no part"},
           {call + "--monte-carlo 9000 --shard 0/3 --save-draws " + at("new.json"), 2, "it is no part"}}) {
    const ToolRun refused = run_tool("predict-error", more);
    EXPECT_EQ(refused.exit_code, code) << more;
    EXPECT_NE(refused.err.find(words), std::string::npos) << refused.err;
  }
  EXPECT_FALSE(fs::exists(folder_ / "new.json"));
}

}  // namespace
}  // namespace procam::test
