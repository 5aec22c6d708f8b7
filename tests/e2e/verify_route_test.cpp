/// verify-projection as a program, on rendered captures with blur and noise: what it finds, corrects and
/// refuses.
#include <gtest/gtest.h>

#include <fstream>

#include "e2e/tool_runner.hpp"
#include "procam/analyze/light_error.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/detect/board_artwork.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/session/patterns.hpp"
#include "procam/simulate/session.hpp"

namespace procam::test {
namespace {

namespace fs = std::filesystem;
constexpr double kBumpDeg = 0.2;

/// The paper-like rig before its bare wall, somewhat more than two metres away.
class VerifyRoute : public ::testing::Test {
 protected:
  void SetUp() override {
    session_ = simulate::make_session(simulate::Level::kPaper, 7, {}, {}, simulate::plain_conditions());
    session_.capture.samples_per_axis = 2;
    world_ = simulate::with_bare_wall(session_.views.front());
    io::save_rig(folder_ / "rig.json", world_.rig);
    save_wall("wall.json", simulate::rig_from_wall(world_));
  }

  void bump_projector() {
    Pose& place = world_.rig.projectors.front().rig_from_projector;
    place =
        place * Pose(so3_exp(Vec3(kBumpDeg * kDegree * Vec3(-0.5, 0.8, 0.33).normalized())), Vec3::Zero());
  }
  void save_wall(const std::string& name, const Pose& rig_from_wall, const std::string& frame = "rig") {
    PlanarSurface plane;
    plane.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    plane.points = {{-0.6, -0.4}, {0.6, -0.4}, {0.6, 0.4}, {-0.6, 0.4}};
    plane.frame = frame;
    plane.frame_from_surface = rig_from_wall;
    io::save_surfaces(folder_ / name, {{{"wall", plane, {}, ""}}});
  }
  std::vector<ImageU8> capture(const std::string& pattern) const {
    return simulate::capture(
        world_, session::make_pattern(pattern, world_.rig.projector().projector.size())->frames(),
        session_.capture);
  }
  void save(const std::string& name, const std::vector<ImageU8>& images) const {
    fs::create_directories(folder_ / name);
    for (std::size_t i = 0; i < images.size(); ++i)
      io::save_image(folder_ / name / ("frame_" + std::to_string(i) + ".png"), images[i]);
  }
  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  ToolRun verify(const std::string& more, const std::string& captures = "seen",
                 const std::string& pattern = "charuco") const {
    return run_tool("verify-projection", "--rig " + at("rig.json") + " --captures " + at(captures) +
                                             " --pattern " + pattern + " " + more);
  }
  ToolRun refused(int exit_code, const std::string& why, const std::string& more,
                  const std::string& captures = "seen", const std::string& pattern = "charuco") const {
    const ToolRun run = verify(more, captures, pattern);
    EXPECT_EQ(run.exit_code, exit_code) << why << ": " << run.err;
    EXPECT_NE(run.err.find(why), std::string::npos) << run.err;
    return run;
  }

  ScratchFolder folder_;
  simulate::SimulatedSession session_;
  simulate::World world_;
};

TEST_F(VerifyRoute, FindsABumpAndBringsTheLightBack) {
  bump_projector();
  save("seen", capture("charuco"));
  const std::string wall = "--surfaces " + at("wall.json");
  const double before = analyze::true_light_error(io::load_rig(folder_ / "rig.json"), world_.rig, 2).worst_mm;
  EXPECT_GT(before, 6);
  const ToolRun run = verify(wall + " --correct projector --sigma-bump 1deg,20mm -o " + at("corrected.json") +
                             " --preview " + at("seen.svg") + " --json");
  ASSERT_EQ(run.exit_code, 5) << run.err;
  const auto json = run.json();
  EXPECT_TRUE(json.at("alarm").get<bool>());
  EXPECT_NEAR(json.at("projector_moved").at("angle_deg").get<double>(), kBumpDeg, 0.1 * kBumpDeg);
  EXPECT_GT(json.at("rms_mm").get<double>(), 6);
  EXPECT_LT(json.at("rms_after_mm").get<double>(), 0.2);
  EXPECT_GT(json.at("marks").size(), 100u);
  EXPECT_GT(json.at("marks")[0].at("sigma_mm")[0].get<double>(), 0);
  EXPECT_EQ(slurp(folder_ / "seen.svg").rfind("<svg", 0), 0u);

  const Rig corrected = io::load_rig(folder_ / "corrected.json");
  EXPECT_LT(analyze::true_light_error(corrected, world_.rig, 2).worst_mm, 1);
  EXPECT_EQ(corrected.provenance.tool, world_.rig.provenance.tool);
  EXPECT_NE(corrected.provenance.options.at("corrected").find("rotated by 0."), std::string::npos);
  EXPECT_EQ(corrected.provenance.inputs.size(), world_.rig.provenance.inputs.size() + 3);

  fs::rename(folder_ / "corrected.json", folder_ / "rig.json");
  EXPECT_EQ(verify(wall).exit_code, 0);
  io::save_rig(folder_ / "rig.json", session_.rig());
  refused(4, "the marks say that projector rotated by 0.",
          wall + " --correct surface -o " + at("moved.json"));
  EXPECT_FALSE(fs::exists(folder_ / "moved.json"));
}

TEST_F(VerifyRoute, KeepsQuietAndFindsAMovedSurface) {
  save("seen", capture("charuco"));
  const ToolRun well =
      verify("--surfaces " + at("wall.json") + " --correct projector -o " + at("same.json") + " --json");
  ASSERT_EQ(well.exit_code, 0) << well.err;
  EXPECT_FALSE(well.json().at("alarm").get<bool>());
  EXPECT_LT(well.json().at("rms_mm").get<double>(), 0.2);
  EXPECT_EQ(slurp(folder_ / "same.json"), slurp(folder_ / "rig.json"));

  // The file says that the wall stands elsewhere: somebody has moved it since.
  Vec6 moved = Vec6::Zero();
  moved << 0.004, -0.007, 0, 0, 0, 0.012;
  const Pose truth = simulate::rig_from_wall(world_);
  save_wall("stale.json", truth * se3_exp(moved));
  const ToolRun run =
      verify("--surfaces " + at("stale.json") + " --correct surface -o " + at("moved.json") + " --json");
  ASSERT_EQ(run.exit_code, 5) << run.err;
  const auto corrected =
      std::get<PlanarSurface>(io::load_surfaces(folder_ / "moved.json").surfaces[0].geometry);
  for (const Vec2& corner : corrected.points)
    EXPECT_NEAR(
        Plane::of_xy(truth).signed_distance(corrected.frame_from_surface * Vec3(corner.x(), corner.y(), 0)),
        0, 1e-3);
  EXPECT_LT(run.json().at("rms_after_mm").get<double>(), 0.2);
  // 0.3 degrees about is within what is stated here.
  EXPECT_EQ(verify("--surfaces " + at("stale.json") + " --map-sigma 0.5deg,10mm").exit_code, 0);

  save_wall("behind.json", Pose(truth.rotation, -truth.translation));
  refused(3, "cannot reach the surface", "--surfaces " + at("behind.json"));
  save_wall("world.json", truth, "world");
  refused(3, "--pose", "--surfaces " + at("world.json"));
  save_wall("projector.json", truth, "projector");
  refused(3, "moves with it", "--surfaces " + at("projector.json"));
}

TEST_F(VerifyRoute, RefusesCapturesThatShowSomethingElse) {
  const std::vector<ImageU8> seen = capture("charuco");
  const std::string wall = "--surfaces " + at("wall.json");
  save("seen", seen);
  refused(3, "is not found", wall, "seen", "markers");
  refused(3, "not a projected board", wall, "seen", "gray");
  save("swapped", {seen[1], seen[0]});
  refused(3, "swapped", wall, "swapped");
  Pose behind = simulate::rig_from_wall(world_);
  behind.translation *= -1;
  save_wall("behind.json", behind);
  refused(3, "cannot reach the surface", "--surfaces " + at("behind.json") + " --preview " + at("marks.svg"));
  EXPECT_FALSE(fs::exists(folder_ / "marks.svg"));
  save("unlit", {ImageU8(seen[0].size(), 1, 9), ImageU8(seen[0].size(), 1, 8)});
  refused(3, "same light", wall, "unlit");
  std::vector<ImageU8> corner = seen;  // all but one marker and what is round it is covered
  for (ImageU8& image : corner)
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x)
        if (std::abs(x - 600) > 40 || std::abs(y - 480) > 40) image.at(x, y) = 20;
  save("corner", corner);
  refused(4, "are needed", wall, "corner");
  save("one", {seen[0]});
  refused(3, "1 frames where the pattern has 2", wall, "one");
  EXPECT_EQ(verify(wall + " --correct projector").exit_code, 2);  // no -o
  EXPECT_EQ(verify(wall + " --sigma-bump 1,20mm").exit_code, 2);  // no unit
  EXPECT_EQ(verify(wall + " --map-sigma=-5mm,0.2deg").exit_code, 2);
  EXPECT_EQ(verify(wall + " --surface floor").exit_code, 3);
}

TEST_F(VerifyRoute, MeasuresTheWallByItsOwnMarkers) {
  // A sheet of markers on the wall, with room for the light beside and below: the sheet is the surface.
  const MarkerGrid grid{3, 2, 0.12, 0.06, MarkerDictionary::kAprilTag36h11};
  world_.board.layout = grid;
  world_.board.artwork = detect::board_artwork(grid);
  world_.board.blank = Vec2(3, 3);
  const Pose wall = simulate::rig_from_wall(world_);
  world_.rig_from_board = wall * Pose(Eigen::Quaterniond::Identity(), Vec3(-0.75, -0.5, 0));
  MarkerMap map;
  map.dictionary = grid.dictionary;
  for (int id = 0; id < grid.marker_count(); ++id) {
    const Vec2 middle = grid.marker_in_board(id) + Vec2::Constant(0.5 * grid.marker_size);
    map.markers.push_back(
        {id, grid.marker_size, Pose(Eigen::Quaterniond::Identity(), Vec3(middle.x(), middle.y(), 0))});
  }
  io::save_marker_map(folder_ / "markers.json", map);
  save_wall("wall.json", Pose(Eigen::Quaterniond::Identity(), Vec3(0.75, 0.5, 0)), "world");
  bump_projector();
  save("seen", capture("charuco"));
  const ToolRun run = verify("--surfaces " + at("wall.json") + " --markers " + at("markers.json") +
                             " --correct projector -o " + at("corrected.json") + " --json");
  ASSERT_EQ(run.exit_code, 5) << run.err;
  EXPECT_NEAR(run.json().at("projector_moved").at("angle_deg").get<double>(), kBumpDeg, 0.1 * kBumpDeg);
  EXPECT_FALSE(run.json().contains("surface_moved"));
  EXPECT_LT(analyze::true_light_error(io::load_rig(folder_ / "corrected.json"), world_.rig, 2).worst_mm, 1);
}

}  // namespace
}  // namespace procam::test
