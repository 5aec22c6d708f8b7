/// align-maps as a program: two robots' files of one room become one pose, and the room of one moves into that of the other.
#include <gtest/gtest.h>

#include "e2e/tool_runner.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/surface_file.hpp"
#include "procam/track/align_maps.hpp"

namespace procam::test {
namespace {

Surface wall(const std::string& name, const Pose& world_from_wall) {
  Surface surface;
  surface.name = name;
  PlanarSurface plane;
  plane.frame_from_surface = world_from_wall;
  plane.content = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  plane.points = {{0, 0}, {1.9, 0}, {1.9, 1.1}, {0, 1.1}};
  surface.geometry = plane;
  return surface;
}

TEST(AlignMapsRoute, TwoRoomsBecomeOne) {
  const ScratchFolder folder;
  const auto at = [&](const char* name) { return (folder / name).string(); };
  // z into the wall: the floor, a wall ahead, one to the left.
  SurfaceSet room;
  room.surfaces = {wall("floor", {so3_exp(Vec3(kPi, 0, 0)), Vec3(0.3, 1.2, 0)}),
                   wall("ahead", {so3_exp(Vec3(-kPi / 2, 0, 0)), Vec3(-0.4, 3.1, 1.6)}),
                   wall("left", {so3_exp(Vec3(0, -kPi / 2, 0)), Vec3(-2.2, 0.4, 1.4)})};
  MarkerMap markers;
  markers.dictionary = MarkerDictionary::kAprilTag36h11;
  markers.markers = {{5, 0.16, {so3_exp(Vec3(-kPi / 2, 0, 0)), Vec3(0.8, 3.1, 1.3)}}};
  markers.position_sigma = 0.003;
  markers.angle_sigma = 0.004;
  const Pose map_a_from_map_b(so3_exp(Vec3(0, 0, 2.2)), Vec3(4.1, -2.7, 0.05));
  io::save_surfaces(at("room_a.json"), room);
  io::save_marker_map(at("markers_a.json"), markers);
  io::save_surfaces(at("room_b.xml"), track::moved(room, map_a_from_map_b.inverse()));
  io::save_marker_map(at("markers_b.json"), track::moved(markers, {map_a_from_map_b.inverse()}));

  const std::string output = " -o " + at("alignment.json");
  const ToolRun run = run_tool("align-maps", "--into " + at("room_a.json") + " " + at("markers_a.json") +
                                                 " --map " + at("room_b.xml") + " " + at("markers_b.json") +
                                                 output + " --write-moved " + at("moved.json"));
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  const FrameTree::Link link = io::load_pose(at("alignment.json"));
  EXPECT_EQ(link.target + " " + link.source, "map_a map_b");
  EXPECT_LT(se3_log(link.target_from_source.pose * map_a_from_map_b.inverse()).norm(), 1e-6);
  EXPECT_GT(link.target_from_source.covariance(5, 5), 1e-7);
  const SurfaceSet moved = io::load_surfaces(at("moved.json"));
  EXPECT_LT((std::get<PlanarSurface>(moved.surfaces[1].geometry).frame_from_surface.translation -
             Vec3(-0.4, 3.1, 1.6))
                .norm(),
            1e-6);

  // The floor and one wall leave a direction open. The file of before stays.
  room.surfaces.pop_back();
  io::save_surfaces(at("room_a.json"), room);
  const ToolRun open =
      run_tool("align-maps", "--into " + at("room_a.json") + " --map " + at("room_b.xml") + output);
  EXPECT_EQ(open.exit_code, 4) << open.err;
  EXPECT_NE(open.err.find("they do not fix the position along (1.00 0.00 0.00) of map A"), std::string::npos)
      << open.err;
  EXPECT_EQ(io::load_pose(at("alignment.json")).source, "map_b");
  const ToolRun wrong =
      run_tool("align-maps", "--into " + at("alignment.json") + " --map " + at("room_b.xml") + output);
  EXPECT_EQ(wrong.exit_code, 3) << wrong.err;
}

}  // namespace
}  // namespace procam::test
