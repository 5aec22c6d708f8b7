/// The wall by a depth camera, a marker and a tape, in the simulated room; and surfaces of a file.
#include "measured_wall.hpp"

#include <gtest/gtest.h>

#include "io/scratch.hpp"
#include "procam/detect/marker_edges.hpp"
#include "procam/io/marker_map_file.hpp"
#include "procam/io/rig_file.hpp"
#include "procam/io/surface_file.hpp"
#include "running_studio.hpp"
#include "simulated_stage.hpp"

namespace procam::studio {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

SimulatedRoom small_room() {
  SimulatedRoom room;
  room.camera_size = {640, 360};
  room.frames_per_s = 20;
  return room;
}
const std::vector<std::string> kSmallRoom = {"--camera-size", "640x360", "--camera-rate", "20"};

Vec3 on_wall(const SimulatedStage& stage, const Vec2& camera_pixel) {
  return *stage.on_wall({Vec3::Zero(), *stage.truth().camera().camera.unproject(camera_pixel)});
}

/// Clockwise from the top left, on the flat wall left of the column; no two sides are parallel.
CameraCorners corners_on_wall() {
  return {Vec2(120, 120), Vec2(270, 131), Vec2(262, 235), Vec2(131, 226)};
}

/// Distance of the surface's corners from the true wall behind them, at most, metres.
double largest_error(const SimulatedStage& stage, const Surface& surface, const CameraCorners& corners) {
  const auto& shape = std::get<PlanarSurface>(surface.geometry);
  double largest = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3 point = shape.frame_from_surface * Vec3(shape.points[i].x(), shape.points[i].y(), 0);
    largest = std::max(largest, (point - on_wall(stage, corners[i])).norm());
  }
  return largest;
}

/// Beyond the plane's rectangle the tape cannot be: the same quadrilateral's sides as they are on the wall.
struct Tape {
  double width, height;
};
/// A rectangle on the wall, upright to its frame, and the pixels of its corners.
CameraCorners rectangle_on_wall(const SimulatedStage& stage, const Tape& tape) {
  const Vec3 corner = on_wall(stage, Vec2(120, 120)), right = on_wall(stage, Vec2(270, 118)),
             below = on_wall(stage, Vec2(121, 240));
  const Vec3 x = (right - corner).normalized(), normal = x.cross(below - corner).normalized(),
             y = normal.cross(x);
  CameraCorners corners;
  const std::array<Vec2, 4> at = {Vec2(0, 0), Vec2(1, 0), Vec2(1, 1), Vec2(0, 1)};
  for (std::size_t i = 0; i < 4; ++i)
    corners[i] = *stage.truth().camera().camera.project(corner + at[i].x() * tape.width * x +
                                                        at[i].y() * tape.height * y);
  return corners;
}

TEST(MeasuredWall, WidthAndHeightGiveItsPlane) {
  const SimulatedStage stage(small_room());
  const Rig& rig = stage.truth();
  const Tape tape{0.52, 0.33};
  CameraCorners corners = rectangle_on_wall(stage, tape);
  const Plane plane = plane_of_size(rig, corners, tape.width, tape.height);
  const Surface surface = surface_on(plane, rig, corners, "w").surface;
  EXPECT_LT(largest_error(stage, surface, corners), 1e-6);
  const Vec2 sides = side_lengths(surface);
  EXPECT_NEAR(sides.x(), tape.width, 1e-6);
  EXPECT_NEAR(sides.y(), tape.height, 1e-6);
  EXPECT_THROW(plane_of_size(rig, corners, tape.height, 2 * tape.width), Error);
  EXPECT_THROW(plane_of_size(rig, corners, 520, 330), Error);
  EXPECT_THROW(plane_of_size(rig, corners, NAN, 0.3), Error);
  corners[1] = Vec2(NAN, 3);
  EXPECT_THROW(plane_of_size(rig, corners, tape.width, tape.height), Error);
}

TEST(MeasuredWall, ADepthCameraGivesIt) {
  SimulatedStage stage(small_room());
  const Rig& rig = stage.truth();
  int pumped = 0;
  const ImageF depth = mean_depth(stage.depth_camera(), rig.camera().camera, 10, [&] { ++pumped; });
  EXPECT_GE(pumped, 10);
  const std::vector<ScanPoint> points = points_of_depth(depth::DepthImage(depth), rig);
  EXPECT_GT(points.size(), 20000u);
  const FittedSurface fitted = fit_surface(points, rig, corners_on_wall(), "w");
  // Disparities are rounded to steps of 13 mm here; over thousands of pixels little remains.
  EXPECT_LT(fitted.rms, 6e-3);
  EXPECT_LT(largest_error(stage, fitted.surface, corners_on_wall()), 2.5e-3);
  Camera other = rig.camera().camera;
  other.size.width += 2;
  EXPECT_THROW(mean_depth(stage.depth_camera(), other, 1, [] {}), Error);
  EXPECT_THROW(points_of_depth(depth::DepthImage(ImageF(rig.camera().camera.size).view()), rig), Error);
}

/// What the page's commands do: the studio measures the wall in each way, and knows it again after kill -9.
class MeasuringStudio : public testing::Test {
 protected:
  MeasuringStudio() : stage_(small_room()), project_(scratch_ / "stage") {
    fs::create_directory(project_);
    io::save_rig(project_ / "rig.json", stage_.truth());
    start();
    command({{"do", "display"}, {"text", "simulated"}});
    command({{"do", "camera"}, {"text", "simulated"}});
    command({{"do", "step"}, {"text", "surfaces"}});
    EXPECT_TRUE(wait([](const json& s) { return s["step"] == "surfaces" && s["camera"]["size"][0] == 640; }));
  }
  void start() {
    studio_ = std::make_unique<test::RunningStudio>(project_, kSmallRoom);
    script_ = std::make_unique<test::Script>(*studio_);
    ASSERT_TRUE(script_->wait_for_start());
  }
  void command(const json& message) { script_->command(message); }
  bool wait(const std::function<bool(const json&)>& holds) { return script_->wait(holds, 120); }

  void measure_by(const std::string& what) {
    command({{"do", "measure_by"}, {"text", what}});
    ASSERT_TRUE(wait([&](const json& s) { return s["surfaces"]["measure_by"] == what; }));
    command({{"do", "scan"}});
    ASSERT_TRUE(wait([&](const json& s) {
      return s["job"] == "" && (s["surfaces"]["scanned"] == true || !s["error"].is_null());
    }));
    ASSERT_TRUE(script_->state()["error"].is_null()) << script_->state()["error"];
  }
  /// The true error of the content on a surface, mm; from clicks.
  double click(const std::string& name, const CameraCorners& corners, std::vector<double> more = {}) {
    std::vector<double> numbers;
    for (const Vec2& corner : corners) numbers.push_back(corner.x()), numbers.push_back(corner.y());
    numbers.insert(numbers.end(), more.begin(), more.end());
    command({{"do", "surface"}, {"name", name}, {"text", "flat"}, {"numbers", numbers}});
    double error = INFINITY;
    EXPECT_TRUE(wait([&](const json& s) {
      for (const json& one : s["surfaces"]["list"])
        if (one["name"] == name) error = one["true_mm"];
      return std::isfinite(error) || !s["error"].is_null();
    }));
    EXPECT_TRUE(script_->state()["error"].is_null()) << script_->state()["error"];
    return error;
  }

  test::Scratch scratch_;
  SimulatedStage stage_;
  fs::path project_;
  std::unique_ptr<test::RunningStudio> studio_;
  std::unique_ptr<test::Script> script_;
};

TEST_F(MeasuringStudio, MarkerDepthAndSizeNeedNoPatterns) {
  const Tape tape{0.5, 0.3};
  command({{"do", "measure_by"}, {"text", "size"}});
  EXPECT_LT(click("by size", rectangle_on_wall(stage_, tape), {tape.width, tape.height}), 0.01);
  measure_by("depth");
  EXPECT_LT(click("by depth", corners_on_wall()), 1);
  measure_by("marker");
  studio_->kill_now();
  start();
  EXPECT_TRUE(script_->state()["surfaces"]["scanned"]);
  EXPECT_EQ(script_->state()["surfaces"]["list"].size(), 2u);
  const double error_mm = click("by marker", corners_on_wall());
  EXPECT_LT(error_mm, 1);
  const SurfaceSet saved = io::load_surfaces(project_ / "surfaces.json");
  ASSERT_EQ(saved.surfaces.size(), 3u);
  // 1.4 mm by the noise of ten images (4 mm by the noise of one): false alarm below 1 in 100 000.
  const double corner_error = largest_error(stage_, saved.surfaces[2], corners_on_wall());
  EXPECT_LT(corner_error, 7e-3);
  std::printf("a marker of 190 mm: content %.2f mm rms, corners %.2f mm\n", error_mm, 1e3 * corner_error);
  // The marker's image is one that locate-projector reads.
  const std::string out = (scratch_ / "pose.json").string();
  EXPECT_EQ(
      std::system((std::string(PROCAM_TOOLS) + "/locate-projector --rig " + (project_ / "rig.json").string() +
                   " --image " + (project_ / "wall_marker.png").string() + " --marker 4x4_50:0:190mm -o " +
                   out + " >/dev/null 2>&1")
                      .c_str()),
      0);
}

TEST_F(MeasuringStudio, TakesTheSurfacesOfAFile) {
  // A niche, seen from inside, and one that this rig cannot place.
  Surface niche, elsewhere;
  niche.name = "niche", elsewhere.name = "elsewhere";
  CylinderSurface shape;
  shape.frame = "rig";
  shape.frame_from_surface = Pose(Eigen::Quaterniond::Identity(), Vec3(0, 0, 1.2));
  shape.radius = 0.8, shape.left = -0.3, shape.right = 0.4, shape.top = -0.2, shape.bottom = 0.15;
  shape.seen_from = SeenFrom::kInside;
  niche.geometry = shape;
  shape.frame = "world";
  elsewhere.geometry = shape;
  io::save_surfaces(project_ / "niche.json", {{niche}});
  io::save_surfaces(project_ / "world.json", {{niche, elsewhere}});
  ASSERT_TRUE(wait([](const json& s) {
    return s["surfaces"].value("files", json()) == json({"niche.json", "world.json"});
  }));
  for (const char* file : {"world.json", "../stage/niche.json", "none.json"}) {
    command({{"do", "add_file"}, {"text", file}});
    ASSERT_TRUE(wait([](const json& s) { return !s["error"].is_null(); })) << file;
    EXPECT_TRUE(script_->state()["surfaces"]["list"].empty()) << file;
    command({{"do", "light"}, {"text", "white"}});
    ASSERT_TRUE(wait([](const json& s) { return s["error"].is_null(); }));
  }
  command({{"do", "add_file"}, {"text", "niche.json"}});
  ASSERT_TRUE(wait([](const json& s) { return s["surfaces"]["list"].size() == 1; }))
      << script_->state()["error"];
  const json added = script_->state()["surfaces"]["list"][0];
  EXPECT_EQ(added["content"], "#ffffff");
  EXPECT_NEAR(added["width"].get<double>(), 0.7 * 0.8, 1e-3);
  EXPECT_NEAR(added["height"].get<double>(), 0.35, 1e-3);
  EXPECT_TRUE(added["corners"].empty()) << "its corners cannot be dragged";
  ASSERT_EQ(added["outline"].size(), 64u);
  const Vec2 first =
      *stage_.truth().camera().camera.project(shape.frame_from_surface * shape.point(Vec2(0, 0)));
  EXPECT_NEAR(added["outline"][0][0].get<double>(), first.x(), 0.01);
  EXPECT_NEAR(added["outline"][0][1].get<double>(), first.y(), 0.01);
  EXPECT_TRUE(std::holds_alternative<CylinderSurface>(
      io::load_surfaces(project_ / "surfaces.json").surfaces[0].geometry));
}

}  // namespace
}  // namespace procam::studio
