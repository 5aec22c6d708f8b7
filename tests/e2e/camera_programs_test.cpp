/// The programs themselves, with what export-camera wrote for them: does their camera look where procam's
/// projector does?
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <sstream>

#include "e2e/tool_runner.hpp"
#include "procam/core/geometry/se3.hpp"
#include "procam/io/image/images.hpp"
#include "procam/io/pose_file.hpp"
#include "procam/io/rig_file.hpp"
#include "support/lopsided.hpp"
#include "support/virtual_screen.hpp"

namespace procam::test {
namespace {

/// Oblong pixels, the axis below the picture and off to one side; no skew and no distortion, which these
/// programs' cameras do not have.
class CameraPrograms : public ::testing::Test {
 protected:
  void SetUp() override {
    Rig rig;
    rig.cameras.push_back({"camera", Camera{{640, 480}, {600, 610, 320, 240, 0}, NoDistortion{}}, Pose()});
    rig.projectors.push_back({"beamer", projector_, Pose()});
    io::save_rig(folder_ / "rig.json", rig);
    io::save_pose(folder_ / "pose.json", {"projector", "world", {projector_from_world_, Mat6::Zero()}});
    std::mt19937_64 random(5);
    while (points_.size() < 12) {
      const Vec2 pixel(uniform(random, 20, projector_.size().width - 20),
                       uniform(random, 20, projector_.size().height - 20));
      const bool is_alone = std::all_of(pixels_.begin(), pixels_.end(),
                                        [&](const Vec2& other) { return (other - pixel).norm() > 18; });
      if (!is_alone) continue;
      const Ray ray = *projector_.emit(pixel);
      points_.push_back(projector_from_world_.inverse() *
                        Vec3(ray.origin + ray.direction * uniform(random, 1.2, 4)));
      pixels_.push_back(pixel);
    }
  }

  /// The text of export-camera for a program.
  std::string settings(const std::string& program) {
    const ToolRun run = run_tool("export-camera", "--rig " + at("rig.json") + " --pose " + at("pose.json") +
                                                      " --near 25cm --for " + program);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.out;
  }

  /// Runs it, and keeps what it said.
  bool is_run(const std::string& command) {
    return std::system((command + " >" + at("said") + " 2>&1 </dev/null").c_str()) == 0;
  }
  std::string said() const { return slurp(folder_ / "said"); }

  /// The pixels of the points, as the program says them in lines of "pixel X Y".
  std::vector<Vec2> pixels_said() const {
    std::istringstream lines(said());
    std::vector<Vec2> pixels;
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line);
      std::string first;
      Vec2 pixel;
      if (words >> first && first == "pixel" && words >> pixel.x() >> pixel.y()) pixels.push_back(pixel);
    }
    return pixels;
  }
  /// The picture seen.png, stretched to the projector's size, has a bright spot on each of the pixels. What
  /// programs draw by chance samples or without smoothing leaves a tenth of a pixel; half a pixel would be
  /// another convention.
  void expect_balls(int background) const {
    const ImageU8 seen = io::to_gray(io::load_image(folder_ / "seen.png").image);
    const Vec2 scale(double(seen.width()) / projector_.size().width,
                     double(seen.height()) / projector_.size().height);
    Vec2 mean = Vec2::Zero();
    for (const Vec2& pixel : pixels_) {
      const Vec2 there = (pixel + Vec2(0.5, 0.5)).cwiseProduct(scale) - Vec2(0.5, 0.5);
      const int reach = int(std::ceil(7 * scale.x()));
      Vec2 sum = Vec2::Zero();
      double light = 0;
      for (int y = int(there.y()) - reach; y <= int(there.y()) + reach + 1; ++y)
        for (int x = int(there.x()) - reach; x <= int(there.x()) + reach + 1; ++x) {
          const int above = std::max(seen.at(x, y) - background, 0);
          sum += above * Vec2(x, y);
          light += above;
        }
      ASSERT_GT(light, 255) << pixel.transpose();
      const Vec2 off = (sum / light - there).cwiseQuotient(scale);
      EXPECT_LT(off.norm(), 0.25) << pixel.transpose();
      mean += off / double(pixels_.size());
    }
    EXPECT_LT(mean.norm(), 0.08) << mean.transpose();
  }

  void expect_pixels(double within) const {
    const std::vector<Vec2> seen = pixels_said();
    ASSERT_EQ(seen.size(), pixels_.size()) << said();
    for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_LT((seen[i] - pixels_[i]).norm(), within) << i;
  }

  std::string at(const std::string& name) const { return (folder_ / name).string(); }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }

  const Projector projector_{Camera{{320, 240}, {587.3, 561.9, 141.2, 262.7, 0}, NoDistortion{}}};
  const Pose projector_from_world_ = Pose(
      so3_exp(Vec3(1.2, -0.9, 1.1)), Vec3(0.4, -0.2, 0.3));  // the world is z up: far from the optical frame
  std::vector<Vec3> points_;                                 ///< in the world
  std::vector<Vec2> pixels_;                                 ///< that light them
  ScratchFolder folder_;
};

std::string list_of(const std::vector<Vec3>& points, const std::string& each) {
  std::ostringstream text;
  text.precision(12);
  for (const Vec3& p : points) text << each << "(" << p.x() << ", " << p.y() << ", " << p.z() << "), ";
  return text.str();
}

// By the matrix that its renderers use, and in a picture: glowing balls of 6 mm at the points, traced by
// Cycles.
TEST_F(CameraPrograms, BlenderLooksWhereTheProjectorDoes) {
  if (!is_run("command -v blender")) GTEST_SKIP() << "no Blender here";
  write("camera.py", settings("blender"));
  write("show.py", R"(import bpy, mathutils
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
camera = bpy.data.objects.new('camera', bpy.data.cameras.new('camera'))
scene.collection.objects.link(camera)
scene.camera = camera
exec(open(')" + at("camera.py") +
                       R"(').read())
glow = bpy.data.materials.new('glow')
glow.use_nodes = True
glow.node_tree.nodes.clear()
light = glow.node_tree.nodes.new('ShaderNodeEmission')
output = glow.node_tree.nodes.new('ShaderNodeOutputMaterial')
glow.node_tree.links.new(light.outputs[0], output.inputs[0])
points = [)" + list_of(points_, "") +
                       R"(]
for point in points:
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=16, radius=0.006, location=point)
    bpy.context.object.data.materials.append(glow)
bpy.context.view_layer.update()
matrix = camera.calc_matrix_camera(bpy.context.evaluated_depsgraph_get(), x=render.resolution_x,
    y=render.resolution_y, scale_x=render.pixel_aspect_x, scale_y=render.pixel_aspect_y)
for point in points:
    clip = matrix @ camera.matrix_world.inverted() @ mathutils.Vector((*point, 1))
    print('pixel', (clip.x / clip.w + 1) / 2 * render.resolution_x - 0.5,
        (1 - clip.y / clip.w) / 2 * render.resolution_y - 0.5)
render.engine = 'CYCLES'
scene.cycles.samples = 128
scene.cycles.use_denoising = False
scene.cycles.use_adaptive_sampling = False
scene.view_settings.view_transform = 'Raw'
render.image_settings.file_format = 'PNG'
render.image_settings.color_mode = 'BW'
render.filepath = ')" + at("seen.png") +
                       R"('
bpy.ops.render.render(write_still=True)
)");
  ASSERT_TRUE(is_run("blender --background --factory-startup --python-exit-code 1 --python " + at("show.py")))
      << said();
  expect_pixels(1e-3);

  expect_balls(0);
}

TEST_F(CameraPrograms, GodotLooksWhereTheProjectorDoes) {
  if (!is_run("command -v godot3")) GTEST_SKIP() << "no Godot 3 here";
  const VirtualScreen screen("640x480");
  if (!screen.is_running()) GTEST_SKIP() << "no Xvfb here";
  std::string text = settings("godot");
  const auto replace = [&](const std::string& from, const std::string& to) {
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from))
      text.replace(at, from.size(), to);
  };
  replace("Camera3D.", "Camera.");
  replace("Transform3D(", "Transform(");
  // The size to render: "a viewport of W x H pixels".
  const std::size_t at_size = text.find("viewport of ");
  ASSERT_NE(at_size, std::string::npos) << text;
  ImageSize size;
  ASSERT_EQ(std::sscanf(text.c_str() + at_size, "viewport of %d x %d", &size.width, &size.height), 2);
  std::vector<Vec3> in_godot;  // x right, y up, z backward; the world is x forward, y left, z up
  for (const Vec3& p : points_) in_godot.emplace_back(-p.y(), p.z(), -p.x());
  std::string indented;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) indented += "\t" + line + "\n";
  write("show.gd", R"(extends SceneTree
func _initialize():
	var viewport = Viewport.new()
	viewport.size = Vector2()" +
                       std::to_string(size.width) + ", " + std::to_string(size.height) + R"()
	viewport.usage = Viewport.USAGE_3D
	viewport.render_target_update_mode = Viewport.UPDATE_ALWAYS
	root.add_child(viewport)
	var camera = Camera.new()
	viewport.add_child(camera)
	camera.current = true
)" + indented + R"(	var glow = SpatialMaterial.new()
	glow.flags_unshaded = true
	var ball = SphereMesh.new()
	ball.radius = 0.012
	ball.height = 0.024
	ball.material = glow
	for point in [)" +
                       list_of(in_godot, "Vector3") + R"(]:
		var body = MeshInstance.new()
		body.mesh = ball
		body.translation = point
		viewport.add_child(body)
	for i in 4:
		yield(VisualServer, "frame_post_draw")
	var seen = viewport.get_texture().get_data()
	seen.flip_y()  # render_target_v_flip would turn the frustum's offset over as well
	seen.save_png(")" +
                       at("seen.png") + R"(")
	quit()
)");
  // Godot writes its logs into the folder it is started in.
  ASSERT_TRUE(is_run("cd " + at(".") + " && DISPLAY=" + screen.name() + " XDG_DATA_HOME=" + at("data") +
                     " timeout 60 godot3 --video-driver GLES2 --audio-driver Dummy -s " + at("show.gd")))
      << said();
  EXPECT_EQ(said().find("set_size: Condition"), std::string::npos) << said();
  expect_balls(100);  // it draws them on grey
}

}  // namespace
}  // namespace procam::test
