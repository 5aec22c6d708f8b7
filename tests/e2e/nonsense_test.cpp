/// The tools that state millimetres, given what cannot be: refused in three parts, with the right exit code,
/// and nothing is written.
#include <gtest/gtest.h>

#include "e2e/tool_runner.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/io/surface_file.hpp"

namespace procam::test {
namespace {

namespace fs = std::filesystem;

class Nonsense : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directory(folder_ / "captures");
    save_surface("wall.json", 1.8);
    save_surface("behind.json", -1.8);
    nlohmann::json rig = nlohmann::json::parse(slurp(truth()));
    rig["covariance"]["names"] = {"projector.fx", "projector.fy"};
    std::ofstream(folder_ / "singular.json")
        << R"({"format": "procam-pose", "version": 1, "target": "projector", "source": "world",
               "translation": [0, 0, 1], "rotation_xyzw": [0, 0, 0, 1], "covariance": [[1, 1, 1, 1, 1, 1],
               [1, 1, 1, 1, 1, 1], [1, 1, 1, 1, 1, 1], [1, 1, 1, 1, 1, 1], [1, 1, 1, 1, 1, 1], [1, 1, 1, 1, 1, 1]]})";
    rig["covariance"]["matrix"] = {{1, 2}, {2, 1}};  // a correlation of 2
    std::ofstream(folder_ / "impossible.json") << rig.dump();
    rig["covariance"]["matrix"] = {{1, 0}, {0, -1}};
    std::ofstream(folder_ / "negative.json") << rig.dump();
  }
  void save_surface(const std::string& name, double z) const {
    PlanarSurface sheet;
    sheet.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    sheet.points = {{-0.1, -0.1}, {0.1, -0.1}, {0.1, 0.1}, {-0.1, 0.1}};
    sheet.frame = "projector";
    sheet.frame_from_surface = Pose(so3_exp(Vec3(0.1, 0.5, 0)), Vec3(0.02, -0.3, z));
    io::save_surfaces(folder_ / name, {{{"sheet", sheet, {}, ""}}});
  }
  static std::string truth() { return std::string(PROCAM_E2E_SESSION) + "/truth.json"; }
  std::string at(const std::string& name) const { return (folder_ / name).string(); }

  struct Case {
    std::string flags;
    int exit_code;
    const char* why;
  };
  /// `folder`: where the program is, if it is no tool.
  void expect_refused(const std::string& tool, const std::vector<Case>& cases,
                      const std::string& folder = "") const {
    for (const Case& bad : cases) {
      SCOPED_TRACE(tool + " " + bad.flags);
      const ToolRun run =
          folder.empty() ? run_tool(tool, bad.flags) : run_program(folder + "/" + tool, bad.flags);
      EXPECT_EQ(run.exit_code, bad.exit_code) << run.err;
      for (const std::string& part : std::vector<std::string>{tool + ": ", "why:", bad.why, "next:"})
        EXPECT_NE(run.err.find(part), std::string::npos) << "no '" << part << "' in: " << run.err;
      for (const char* const file : {"page.html", "plan.svg", "marks.svg", "out.json", "corners.csv"})
        EXPECT_FALSE(fs::exists(folder_ / file)) << file;
    }
  }

  ScratchFolder folder_;
};

TEST_F(Nonsense, IsRefusedByPredictError) {
  const auto call = [&](const std::string& rig, const std::string& surfaces, const std::string& more) {
    return "--rig " + rig + " --surfaces " + at(surfaces) + " --report " + at("page.html") + more;
  };
  expect_refused("predict-error",
                 {{call(truth(), "wall.json", " --map-sigma=-5mm,0.2deg"), 2, "negative"},
                  {call(truth(), "wall.json", " --pose-sigma 10mm,-0.5deg"), 2, "negative"},
                  {call(truth(), "wall.json", " --speed-sigma=-1m/s"), 2, "negative"},
                  {call(truth(), "wall.json", " --map-sigma 5"), 2, "the unit is missing"},
                  {call(truth(), "wall.json", " --delay 50"), 2, "the unit is missing"},
                  {call(at("impossible.json"), "wall.json", ""), 3, "not positive semi-definite"},
                  {call(at("negative.json"), "wall.json", ""), 3, "negative variance"},
                  {call(truth(), "wall.json", " --pose " + at("singular.json")), 3, "it is singular"},
                  {call(truth(), "behind.json", ""), 4, "behind the projector"}});
}

TEST_F(Nonsense, IsRefusedByVerifyProjection) {
  const auto call = [&](const std::string& rig, const std::string& more) {
    return "--rig " + rig + " --surfaces " + at("wall.json") + " --captures " + at("captures") +
           " --pattern charuco --correct projector -o " + at("out.json") + " --preview " + at("marks.svg") +
           more;
  };
  expect_refused("verify-projection", {{call(truth(), " --map-sigma=-5mm"), 2, "negative"},
                                       {call(truth(), " --sigma-bump=-1deg,20mm"), 2, "negative"},
                                       {call(truth(), " --map-sigma 5"), 2, "the unit is missing"},
                                       {call(at("impossible.json"), ""), 3, "not positive semi-definite"},
                                       {call(at("negative.json"), ""), 3, "negative variance"}});
}

#ifdef PROCAM_SECTION_V
TEST_F(Nonsense, IsRefusedBySectionV) {
  const std::string write = " --report " + at("page.html") + " --corners " + at("corners.csv");
  const auto measured = [&](const std::string& name, const std::string& line) {
    std::ofstream(folder_ / name) << line << '\n';
    return "--measured " + at(name) + " --units cm" + write;
  };
  expect_refused(
      "section_v",
      {{"--truth " + truth() + " --rig " + truth() + " --noise=-1" + write, 2, "--noise"},
       {"--truth " + truth() + " --rig " + at("impossible.json") + write, 3, "not positive semi-definite"},
       {measured("behind.csv", "A4, 1, -1.2, 47, 1, 0, 0, 1, 1"), 3, "distance_m is -1.2"},
       {measured("away.csv", "A4, 1, 1.2, 95, 1, 0, 0, 1, 1"), 3, "incidence_deg is 95"},
       {"--measured " + at("behind.csv") + write, 2, "--units"}},
      PROCAM_SECTION_V);
}
#endif

TEST_F(Nonsense, IsRefusedByPlanProjection) {
  const std::string call = "--resolution 1280x800 --throw-ratio 1.2 -o " + at("plan.svg") + " --distance ";
  expect_refused("plan-projection", {{call + "2", 2, "the unit is missing"},
                                     {call + "-2m", 3, "distance -2 m"},
                                     {call + "2m --yaw 180deg", 4, "looks away from the wall"}});
}

}  // namespace
}  // namespace procam::test
