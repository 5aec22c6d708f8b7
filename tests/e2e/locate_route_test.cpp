/// locate-projector and calibrate-camera as programs: from an image of markers to the projector's place.
#include <gtest/gtest.h>

#include "e2e/tool_runner.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/simulate/marker_view.hpp"
#include "procam/simulate/session.hpp"
#include "support/test_data.hpp"

namespace procam::test {
namespace {

namespace fs = std::filesystem;

/// The paper-like rig before its wall of markers.
class LocateRoute : public ::testing::Test {
 protected:
  void SetUp() override {
    const simulate::SimulatedSession session = simulate::make_session(simulate::Level::kPaper, 7);
    const Rig& rig = session.rig();
    hung_ = simulate::hang_markers(session.views.front());
    io::save_rig(folder_ / "rig.json", rig);
    io::save_marker_map(folder_ / "markers.json", hung_.map);
    const MarkerCells codes = detect::marker_cells(MarkerDictionary::kAprilTag36h11);
    io::save_image(folder_ / "view.png",
                   simulate::marker_view(rig.camera().camera,
                                         rig.camera().rig_from_camera.inverse() * hung_.rig_from_world,
                                         hung_.map.markers, codes));
    truth_ = rig.projector().rig_from_projector.inverse() * hung_.rig_from_world;
  }

  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  ToolRun locate(const std::string& more) {
    return run_tool("locate-projector", "--rig " + at("rig.json") + " --image " + at("view.png") + " -o " +
                                            at("pose.json") + " " + more);
  }

  ScratchFolder folder_;
  simulate::HungMarkers hung_;
  Pose truth_;
};

TEST_F(LocateRoute, FindsTheProjectorFromAMapAndFromOneMarker) {
  const ToolRun mapped =
      locate("--markers " + at("markers.json") + " --preview " + at("seen.png") + " --json");
  ASSERT_EQ(mapped.exit_code, 0) << mapped.err;
  const FrameTree::Link pose = io::load_pose(folder_ / "pose.json");
  EXPECT_EQ(pose.target, "projector");
  EXPECT_EQ(pose.source, "world");
  // At three metres; sigmas of 0.02 mm and 0.002 degrees are stated.
  EXPECT_LT((pose.target_from_source.pose.translation - truth_.translation).norm(), 2e-4);
  EXPECT_LT(so3_log(pose.target_from_source.pose.rotation * truth_.rotation.conjugate()).norm(), 2e-4);
  EXPECT_GT(pose.target_from_source.covariance(0, 0), 0);
  EXPECT_EQ(io::load_image(folder_ / "seen.png").image.channels(), 3);
  const auto json = mapped.json();
  EXPECT_EQ(json.at("markers").size(), 4u);
  EXPECT_EQ(json.at("chain").size(), 2u);
  EXPECT_EQ(json.at("chain")[0].at("source"), "camera");

  const PlacedMarker& first = hung_.map.markers.front();  // its frame is the world
  const ToolRun single =
      locate("--marker apriltag_36h11:" + std::to_string(first.id) + ":" + std::to_string(first.size) + "m");
  ASSERT_EQ(single.exit_code, 0) << single.err;
  EXPECT_NE(single.out.find("projector_from_world"), std::string::npos) << single.out;
  EXPECT_LT(
      (io::load_pose(folder_ / "pose.json").target_from_source.pose.translation - truth_.translation).norm(),
      2e-3);
}

TEST_F(LocateRoute, NamesAMarkerThatHangsElsewhere) {
  MarkerMap map = hung_.map;
  map.markers[1].world_from_marker.translation.x() += 0.03;
  io::save_marker_map(folder_ / "wrong.json", map);
  const ToolRun run = locate("--markers " + at("wrong.json"));
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("marker 7 is rejected"), std::string::npos) << run.err;
}

TEST_F(LocateRoute, RefusesWhatItCannotLocate) {
  const ToolRun unseen = locate("--marker 4x4_50:3:160mm");
  EXPECT_EQ(unseen.exit_code, 4) << unseen.err;
  EXPECT_EQ(locate("").exit_code, 2);
  EXPECT_EQ(locate("--marker 4x4_50:3").exit_code, 2);
  io::save_image(folder_ / "view.png", ImageU8(320, 200, 1, 90));
  const ToolRun small = locate("--marker 4x4_50:3:160mm");
  EXPECT_EQ(small.exit_code, 3) << small.err;
  EXPECT_NE(small.err.find("320x200"), std::string::npos) << small.err;
  EXPECT_FALSE(fs::exists(folder_ / "pose.json"));
}

TEST(CalibrateCamera, ReachesTheKnownResidualOnPhotographs) {
  PROCAM_REQUIRE_TEST_DATA("chessboard");
  const ScratchFolder folder;
  fs::create_directory(folder / "left");
  for (const fs::directory_entry& entry : fs::directory_iterator(test_data() / "chessboard"))
    if (entry.path().filename().string().rfind("left", 0) == 0 && entry.path().extension() == ".jpg")
      fs::create_symlink(entry.path(), folder / ("left/" + entry.path().filename().string()));
  const ToolRun run = run_tool("calibrate-camera", "--images " + (folder / "left").string() +
                                                       " --board chessboard:9x6:25mm --json -o " +
                                                       (folder / "camera.json").string());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.json().at("result"), "passed");
  EXPECT_EQ(run.err.rfind("result     passed: RMS 0.", 0), 0u) << run.err;  // before any note
  const Rig rig = io::load_rig(folder / "camera.json");
  EXPECT_EQ(rig.quality.views_used, 13);
  EXPECT_LT(rig.quality.rms_px.at("camera"), 0.195);  // OpenCV's
  EXPECT_NEAR(rig.camera().camera.intrinsics.fx, 533.4, 3);
  EXPECT_TRUE(rig.projectors.empty());
}

TEST(CalibrateCamera, RefusesAFolderWithoutPhotographs) {
  const ScratchFolder folder;
  fs::create_directory(folder / "none");
  const ToolRun run = run_tool("calibrate-camera", "--images " + (folder / "none").string() +
                                                       " --board chessboard:9x6:25mm -o " +
                                                       (folder / "camera.json").string());
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("no image"), std::string::npos) << run.err;
}

}  // namespace
}  // namespace procam::test
