// A drive recorded -> the pose of the rig on its base, as a user does it; and the files that lead there.
#include <gtest/gtest.h>

#include "procam/detect/marker_edges.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/session/mount_data.hpp"
#include "procam/simulate/marker_view.hpp"
#include "procam/track/pose_log.hpp"
#include "tool_runner.hpp"

namespace procam::test {
namespace {

TEST(MountRoute, FindsTheRigOfASimulatedRobot) {
  const ScratchFolder folder;
  const auto file = [&](const char* name) { return (folder / name).string(); };
  ASSERT_EQ(run_tool("simulate-robot",
                     "--path walk --duration 40s --noise 10mm,0.5deg --seed 3 --clock-offset 80ms -o " +
                         file("base.log") + " --sightings " + file("sightings.log") + " --save-mount " +
                         file("true.json"))
                .exit_code,
            0);
  const Pose truth = io::load_pose(file("true.json")).target_from_source.pose;
  const std::string inputs = "--base " + file("base.log") + " --sightings " + file("sightings.log") + " -o " +
                             file("mount.json") + " --preview " + file("mount.svg") + " --json ";

  // The drive in a plane cannot observe the height: it is asked for, and no file appears.
  const ToolRun refused = run_tool("calibrate-mount", inputs);
  EXPECT_EQ(refused.exit_code, 4) << refused.err;
  EXPECT_NE(refused.err.find("height"), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("--height 0.85m+-5mm"), std::string::npos) << refused.err;
  EXPECT_FALSE(std::filesystem::exists(file("mount.json")));

  const ToolRun run =
      run_tool("calibrate-mount", inputs + "--height " + std::to_string(truth.translation.z()) + "m+-2mm");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json json = run.json();
  EXPECT_EQ(json["unobservable"], nlohmann::json({"height"}));
  EXPECT_NEAR(json["time_offset"].get<double>(), 0.08, 0.006);
  EXPECT_EQ(json["markers"].size(), 8u);
  const FrameTree::Link mount = io::load_pose(file("mount.json"));
  EXPECT_EQ(mount.target + "_from_" + mount.source, "base_from_rig");
  const Vec6 error = se3_log(mount.target_from_source.pose * truth.inverse());
  EXPECT_LT(error.dot(mount.target_from_source.covariance.ldlt().solve(error)), 27.9);  // 1 in 10 000
  EXPECT_NE(slurp(file("mount.svg")).find("<ellipse"), std::string::npos);

  // A flag without its deviation, and one that counts for two things.
  EXPECT_EQ(run_tool("calibrate-mount", inputs + "--height 0.85m").exit_code, 2);
  EXPECT_EQ(run_tool("calibrate-mount", inputs + "--height 70m+-5mm").exit_code, 2);
  EXPECT_EQ(run_tool("calibrate-mount", "--base " + file("base.log") + " -o " + file("mount.json")).exit_code,
            2);
  EXPECT_EQ(run_tool("calibrate-mount", inputs + "--height 0.7m+-2mm --child robot").exit_code, 3);
}

TEST(MountRoute, FindsTheRigByFloorAndWalls) {
  const ScratchFolder folder;
  const auto file = [&](const char* name) { return (folder / name).string(); };
  ASSERT_EQ(
      run_tool(
          "simulate-robot",
          "--path walk --duration 40s --noise 10mm,0.5deg --seed 4 --clock-offset 80ms --see planes -o " +
              file("base.log") + " --sightings " + file("sightings.log") + " --save-mount " +
              file("true.json"))
          .exit_code,
      0);
  const std::string inputs = "--base " + file("base.log") + " --sightings " + file("sightings.log") + " -o " +
                             file("mount.json") + " --preview " + file("mount.svg") + " --json ";
  const ToolRun refused = run_tool("calibrate-mount", inputs);
  EXPECT_EQ(refused.exit_code, 4) << refused.err;
  EXPECT_NE(refused.err.find("--floor 0mm+-1mm"), std::string::npos) << refused.err;
  const ToolRun run = run_tool("calibrate-mount", inputs + "--floor 0mm+-1mm");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json json = run.json();
  EXPECT_TRUE(json["unobservable"].empty());
  EXPECT_NEAR(json["time_offset"].get<double>(), 0.08, 0.01);
  EXPECT_TRUE(json["markers"].empty());
  EXPECT_GE(json["planes"].size(), 3u);
  EXPECT_NEAR(json["plane_factor"].get<double>(), 1, 0.15);
  const Pose truth = io::load_pose(file("true.json")).target_from_source.pose;
  const FrameTree::Link mount = io::load_pose(file("mount.json"));
  const Vec6 error = se3_log(mount.target_from_source.pose * truth.inverse());
  EXPECT_LT(error.dot(mount.target_from_source.covariance.ldlt().solve(error)), 27.9);  // 1 in 10 000
  EXPECT_NE(slurp(file("mount.svg")).find("walls (green)"), std::string::npos);
  EXPECT_EQ(run_tool("calibrate-mount", inputs + "--floor 0mm").exit_code, 2);
  EXPECT_EQ(run_tool("simulate-robot", "--see walls -o " + file("base.log")).exit_code, 2);
}

/// A furnished room, as a Kinect sees it. Nobody names its planes.
TEST(MountRoute, FindsTheRigByDepthImages) {
  const ScratchFolder folder;
  const auto file = [&](const char* name) { return (folder / name).string(); };
  ASSERT_EQ(
      run_tool(
          "simulate-robot",
          "--path walk --duration 15s --noise 10mm,0.5deg --seed 3 --clock-offset 80ms --see planes -o " +
              file("base.log") + " --sightings " + file("sightings.log") + " --save-mount " +
              file("true.json") + " --save-depth " + file("depth"))
          .exit_code,
      0);
  const std::string inputs = "--base " + file("base.log") + " --depth " + file("depth") +
                             " --intrinsics 585,585,319.5,239.5 -o " + file("mount.json") + " --json ";
  const ToolRun run = run_tool("calibrate-mount", inputs + "--floor 0mm+-1mm");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json json = run.json();
  EXPECT_TRUE(json["unobservable"].empty());
  EXPECT_NEAR(json["time_offset"].get<double>(), 0.08, 0.01);
  const Pose truth = io::load_pose(file("true.json")).target_from_source.pose;
  const FrameTree::Link mount = io::load_pose(file("mount.json"));
  const Vec6 error = se3_log(mount.target_from_source.pose * truth.inverse());
  EXPECT_LT(error.dot(mount.target_from_source.covariance.ldlt().solve(error)), 27.9);  // 1 in 10 000
  const Vec3 ahead(0, 0, 2);
  EXPECT_LT((mount.target_from_source.pose * ahead - truth * ahead).norm(), 0.015);

  const ToolRun metres = run_tool("calibrate-mount", inputs + "--floor 0mm+-1mm --depth-scale 0.01mm");
  EXPECT_EQ(metres.exit_code, 3);
  EXPECT_NE(metres.err.find("median depth"), std::string::npos) << metres.err;
  EXPECT_EQ(run_tool("calibrate-mount",
                     "--base " + file("base.log") + " --depth " + file("depth") + " -o " + file("mount.json"))
                .exit_code,
            2)
      << "without intrinsics";
  EXPECT_EQ(run_tool("simulate-robot", "--path walk --see planes -o " + file("base.log") + " --sightings " +
                                           file("sightings.log") + " --save-depth " + file("depth"))
                .exit_code,
            3)
      << "the folder holds files";
}

/// Its projector shows markers on walls and floor, and its camera sees them.
TEST(MountRoute, FindsTheRigByItsOwnLight) {
  const ScratchFolder folder;
  const auto file = [&](const char* name) { return (folder / name).string(); };
  ASSERT_EQ(
      run_tool(
          "simulate-robot",
          "--path walk --duration 12s --noise 10mm,0.5deg --seed 3 --clock-offset 80ms --see planes -o " +
              file("base.log") + " --sightings " + file("sightings.log") + " --save-mount " +
              file("true.json") + " --save-light " + file("light"))
          .exit_code,
      0);
  const std::string inputs = "--base " + file("base.log") + " --light " + file("light") + " --rig " +
                             file("light/rig.json") + " --floor 0mm+-1mm -o " + file("mount.json") +
                             " --json ";
  const ToolRun run = run_tool("calibrate-mount", inputs);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_GT(run.json()["sightings_used"].get<int>(), 100);
  const Pose truth = io::load_pose(file("true.json")).target_from_source.pose,
             mount = io::load_pose(file("mount.json")).target_from_source.pose;
  EXPECT_LT((mount.translation - truth.translation).norm(), 0.04);
  EXPECT_NEAR(mount.translation.z(), truth.translation.z(), 0.006);
  const ToolRun other = run_tool("calibrate-mount", inputs + "--pattern gray");
  EXPECT_EQ(other.exit_code, 3) << other.err;
  EXPECT_NE(other.err.find("not a projected board"), std::string::npos) << other.err;
}

/// Of a head and of an arm: the mount, and where they stand in the room.
void expect_mount_like_the_true_one(const ScratchFolder& folder, const std::string& path,
                                    const std::string& flag) {
  const auto file = [&](const char* name) { return (folder / name).string(); };
  ASSERT_EQ(run_tool("simulate-robot", "--path " + path + " --duration 20s --seed 5 --clock-offset 40ms -o " +
                                           file("motion.log") + " --sightings " + file("sightings.log") +
                                           " --save-mount " + file("true.json") + " --save-markers " +
                                           file("markers.json"))
                .exit_code,
            0);
  const ToolRun run = run_tool(
      "calibrate-mount", flag + " " + file("motion.log") + " --sightings " + file("sightings.log") +
                             " --markers " + file("markers.json") + " -o " + file("mount.json") + " --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NEAR(run.json()["time_offset"].get<double>(), 0.04, 0.002);
  const io::Mount truth = io::load_mount(file("true.json")), found = io::load_mount(file("mount.json"));
  const Vec6 error =
      se3_log(found.pose.target_from_source.pose * truth.pose.target_from_source.pose.inverse());
  EXPECT_LT(error.dot(found.pose.target_from_source.covariance.ldlt().solve(error)), 27.9);  // 1 in 10 000
  EXPECT_LT(error.tail<3>().norm(), 0.003) << error.transpose();
  ASSERT_TRUE(found.world_from_base && truth.world_from_base);
  EXPECT_LT((found.world_from_base->translation - truth.world_from_base->translation).norm(), 0.002);
}

TEST(MountRoute, FindsTheRigOnAnArm) {
  const ScratchFolder folder;
  expect_mount_like_the_true_one(folder, "arm", "--arm");
  EXPECT_EQ(io::load_mount(folder / "mount.json").pose.target, "flange");
}

TEST(MountRoute, FindsTheRigOnAPanTiltHead) {
  const ScratchFolder folder;
  expect_mount_like_the_true_one(folder, "pan-tilt", "--pan-tilt");
  const io::Mount found = io::load_mount(folder / "mount.json"), truth = io::load_mount(folder / "true.json");
  ASSERT_TRUE(found.axes && truth.axes);
  EXPECT_NEAR(found.axes->offset, truth.axes->offset, 0.002);
  EXPECT_NEAR(found.axes->angle, truth.axes->angle, 0.1 * kDegree);
  // What does not know the axes would show at a wrong place.
  EXPECT_THROW(io::load_pose(folder / "mount.json"), Error);
}

track::StampedPose message(double time, const char* frame, const char* child) {
  track::StampedPose made;
  made.stamp = time;
  made.arrival = time;
  made.frame = frame;
  made.child = child;
  return made;
}

TEST(MountData, ReadsOneLogOfBothAndSkipsWhatIsNeither) {
  const ScratchFolder folder;
  const std::string file = (folder / "run.log").string();
  {
    track::PoseLogWriter log(file);
    for (int i = 0; i < 4; ++i) {
      log.write(message(10 + i, "map", "base"));
      log.write(message(10 + i, "map", "laser"));
      track::StampedPose seen = message(9.5 + i, "marker_3", "rig");
      seen.arrival = 10 + i;
      seen.covariance = 1e-6 * Mat6::Identity();
      log.write(seen);
    }
    track::StampedPose late = message(11, "map", "base");  // overtaken
    late.arrival = 14;
    log.write(late);
  }
  session::MountFiles files;
  files.base = files.sightings = file;
  const session::MountRecording recording = session::read_mount_data(files);
  EXPECT_EQ(recording.data.base.size(), 4u);
  EXPECT_EQ(recording.data.sightings.size(), 4u);
  EXPECT_EQ(recording.data.sightings[2].marker, "marker_3");
  EXPECT_DOUBLE_EQ(recording.data.sightings[2].time, 11.5);
  EXPECT_EQ(recording.world, "map");
  EXPECT_NE(recording.diagnostics.find("poses_out_of_order"), nullptr);
  files.rig = "head";
  EXPECT_THROW(session::read_mount_data(files), Error);
  files.rig = "laser";  // without covariance
  EXPECT_THROW(session::read_mount_data(files), Error);
}

TEST(MountData, ReportsAClockThatWasSetAndSkipsRepeatedPoses) {
  const ScratchFolder folder;
  session::MountFiles files;
  files.base = (folder / "base.log").string();
  const auto recording = [&](double clock_jump, int repeats) {
    {
      track::PoseLogWriter log(files.base);
      for (int i = 0; i < 80; ++i) {
        const double time = 10 + 0.05 * i;
        track::StampedPose pose = message(time + (i >= 50 ? clock_jump : 0), "map", "base");
        pose.arrival = time + 0.1 + 0.002 * (i % 3);
        pose.frame_from_child.translation.x() = 0.01 * double(i - i % repeats);
        log.write(pose);
      }
    }
    return session::read_mount_data(files);
  };
  EXPECT_EQ(recording(0, 1).diagnostics.find("clock_jumped"), nullptr);
  for (const double jump : {0.15, -0.04}) {
    const session::MountRecording jumped = recording(jump, 1);
    const Diagnostic* const remark = jumped.diagnostics.find("clock_jumped");
    ASSERT_NE(remark, nullptr) << jump;
    EXPECT_NE(remark->message.find(jump > 0 ? " 150 ms" : " -40 ms"), std::string::npos) << remark->message;
    EXPECT_EQ(jumped.diagnostics.failed(), jump > 0) << "a delay of the network may be 40 ms";
  }
  // Each pose four times.
  const session::MountRecording repeated = recording(0, 4);
  EXPECT_EQ(repeated.data.base.size(), 20u);
  EXPECT_DOUBLE_EQ(repeated.data.base[1].time, 10.2);
  EXPECT_NE(repeated.diagnostics.find("poses_repeated"), nullptr);
}

TEST(MountData, FindsSingleMarkersInImagesNamedAfterTheirTimes) {
  const ScratchFolder folder;
  RigCamera camera;
  camera.name = "front";
  camera.camera.size = {640, 480};
  camera.camera.intrinsics = {560, 566, 331, 236, 0.3};
  camera.rig_from_camera = Pose(so3_exp(Vec3(0.02, -0.05, 0.01)), Vec3(0.1, 0.02, -0.03));
  const MarkerCells cells = detect::marker_cells(MarkerDictionary::kAprilTag36h11);
  const Pose camera_from_world(so3_exp(Vec3(0.1, 0.5, -0.05)), Vec3(0.02, -0.03, 0.9));
  const std::vector<PlacedMarker> markers{
      {3, 0.16, Pose(Eigen::Quaterniond::Identity(), Vec3(-0.15, 0, 0))},
      {8, 0.16, Pose(Eigen::Quaterniond::Identity(), Vec3(0.15, 0.05, 0))}};
  const ImageU8 image = simulate::marker_view(camera.camera, camera_from_world, markers, cells);
  io::save_image(folder / "1403636579763555584.png", image.view());
  io::save_image(folder / "12.25.png", image.view());
  session::SightingImages images;
  images.folder = folder / "";
  images.size = 0.16;
  const std::vector<MarkerSighting> seen = session::sightings_in_images(images, camera);
  ASSERT_EQ(seen.size(), 4u);
  EXPECT_DOUBLE_EQ(seen[0].time, 12.25);
  EXPECT_NEAR(seen[2].time, 1403636579.763555584, 1e-6);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(seen[i].marker, i == 0 ? "marker_3" : "marker_8");
    const Pose truth = (camera.rig_from_camera * camera_from_world * markers[i].world_from_marker).inverse();
    const Vec6 error = se3_log(seen[i].marker_from_rig.pose * truth.inverse());
    EXPECT_LT(error.dot(seen[i].marker_from_rig.covariance.ldlt().solve(error)), 40);
  }
  io::save_image(folder / "front.png", image.view());
  EXPECT_THROW(session::sightings_in_images(images, camera), Error);
}

}  // namespace
}  // namespace procam::test
